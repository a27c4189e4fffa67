/* Rows of a hierarchy are dealt out whole, once, and with copies of all that is read. */
#include "memory.h"
#include "random.h"
#include "share.h"
#include "systems.h"
#include "testing.h"

enum { SLICE = 8 };

/* A hierarchy and what it is shared like. */
typedef struct shared {
    pc_multigrid multigrid;
    pc_row_order order[PC_MOST_LEVELS];
    pc_share share;
} shared;

static void make_shared(shared *s, pc_context *ctx, const pc_system *system, int members, pc_index least) {
    const pc_row_order *orders[PC_MOST_LEVELS];
    assert_ok(ctx, pc_multigrid_make(&s->multigrid, ctx, system));
    for (int k = 0; k < s->multigrid.level_count; k++) {
        assert_ok(ctx, pc_row_order_make(&s->order[k], ctx, &s->multigrid.level[k].matrix));
        orders[k] = &s->order[k];
    }
    assert_ok(ctx, pc_share_make(&s->share, ctx, &s->multigrid, orders, members, SLICE, least));
}

static void free_shared(shared *s, pc_context *ctx) {
    pc_share_free(&s->share, ctx);
    for (int k = 0; k < s->multigrid.level_count; k++)
        pc_row_order_free(&s->order[k], ctx);
    pc_multigrid_free(&s->multigrid, ctx);
}

/* Every row has one member and one maker; places of own rows and of copies are what they should be. */
static void check_rows(const shared *s, int k) {
    const pc_share *share = &s->share;
    const pc_index n = s->order[k].count;
    pc_index owned = 0;
    pc_index made = 0;
    for (int m = 0; m < share->member_count; m++) {
        const pc_share_rows *rows = pc_share_of(share, k, m);
        const pc_row_order *order = &rows->order;
        const pc_index first = (order->count + SLICE - 1) / SLICE * SLICE;
        pc_index known = 0;
        owned += order->count;
        made += rows->made ? rows->made_count : order->count;
        assert_true((rows->made == NULL) == (k < share->spread));
        for (pc_index place = 0; place < order->count; place++) {
            assert_int_equal(order->place[order->row[place]], place);
            if (place > 0)
                assert_true(s->order[k].place[order->row[place]] > s->order[k].place[order->row[place - 1]]);
        }
        for (pc_index row = 0; row < n; row++) {
            if (order->place[row] == PC_NONE) continue;
            assert_true(order->place[row] < order->count ||
                        (order->place[row] >= first && order->place[row] < first + order->copies));
            known++;
        }
        assert_int_equal(known, order->count + order->copies);
    }
    assert_int_equal(owned, n);
    assert_int_equal(made, n);
}

/* What a member sends is what the other expects, in its order. */
static void check_copies(const shared *s, int k) {
    const int members = s->share.member_count;
    for (int from = 0; from < members; from++) {
        const pc_share_rows *sender = pc_share_of(&s->share, k, from);
        for (int to = 0; to < members; to++) {
            const pc_share_rows *receiver = pc_share_of(&s->share, k, to);
            const pc_index first = (receiver->order.count + SLICE - 1) / SLICE * SLICE;
            const pc_index count = sender->sent_start[to + 1] - sender->sent_start[to];
            assert_int_equal(receiver->copied_start[from + 1] - receiver->copied_start[from], count);
            if (from == to) assert_int_equal(count, 0);
            for (pc_index i = 0; i < count; i++) {
                const pc_index row = sender->order.row[sender->sent[sender->sent_start[to] + i]];
                assert_int_equal(receiver->order.place[row], first + receiver->copied_start[from] + i);
            }
        }
    }
}

static void check_columns(const pc_blockmat *a, const pc_index *row, pc_index count,
                          const pc_row_order *columns) {
    for (pc_index i = 0; i < count; i++)
        for (pc_index e = a->start[row[i]]; e < a->start[row[i] + 1]; e++)
            assert_true(columns->place[a->column[e]] != PC_NONE);
}

/* All that a member's products read is there. */
static void check_products(const shared *s) {
    const pc_share *share = &s->share;
    for (int k = 0; k < share->spread; k++) {
        const pc_level *level = &s->multigrid.level[k];
        for (int m = 0; m < share->member_count; m++) {
            const pc_row_order *own = &pc_share_of(share, k, m)->order;
            check_columns(&level->matrix, own->row, own->count, own);
            if (k + 1 == share->level_count) continue;
            const pc_share_rows *next = pc_share_of(share, k + 1, m);
            check_columns(&level->prolongator, own->row, own->count, &next->order);
            check_columns(&level->restriction, next->made ? next->made : next->order.row,
                          next->made ? next->made_count : next->order.count, own);
        }
    }
}

/* Blocks of the finest level stay whole, and the runs tell where they are. */
static void check_runs(const shared *s) {
    const pc_share *share = &s->share;
    const pc_row_order *whole = &s->order[0];
    pc_index next = 0;
    for (pc_index r = 0; r < share->run_count; r++) {
        const pc_share_run *run = &share->run[r];
        const pc_row_order *own = &pc_share_of(share, 0, run->member)->order;
        assert_int_equal(run->whole, next);
        next += run->count;
        for (pc_index place = run->whole * PC_SHARE_BLOCK;
             place < next * PC_SHARE_BLOCK && place < whole->count; place++)
            assert_int_equal(own->place[whole->row[place]],
                             place - (run->whole - run->first) * PC_SHARE_BLOCK);
    }
    assert_int_equal(next, (whole->count + PC_SHARE_BLOCK - 1) / PC_SHARE_BLOCK);
}

static void check(pc_context *ctx, const pc_system *system, int members, pc_index least) {
    shared s;
    make_shared(&s, ctx, system, members, least);
    for (int k = 0; k < s.share.level_count; k++) {
        check_rows(&s, k);
        check_copies(&s, k);
    }
    check_products(&s);
    check_runs(&s);
    free_shared(&s, ctx);
}

static void everything_is_dealt_out_once(void **state) {
    pc_context *ctx = *state;
    for (int k = 0; k < 8; k++) {
        pc_system system;
        if (k % 2 == 0) {
            pc_synth_options torus = PC_SYNTH_DEFAULTS;
            torus.around = 151, torus.across = 120;
            assert_ok(ctx, pc_synth_torus_system(&system, ctx, PC_BLOCK_COMPLEX, &torus));
        } else {
            assert_ok(ctx, pc_synth_random_system(&system, ctx, PC_BLOCK_TURNED, 9000, 4, 1.05, (uint64_t)k));
        }
        check(ctx, &system, 2 + k % 3, k < 4 ? 1 : 3000);
        check(ctx, &system, PC_MOST_MEMBERS, 1);
        pc_system_free(&system, ctx);
    }
}

/* Members get about as many rows, and on a surface in locality order few copies. */
static void halves_are_fair(void **state) {
    pc_context *ctx = *state;
    pc_system system;
    shared s;
    pc_synth_options torus = PC_SYNTH_DEFAULTS;
    torus.around = 120, torus.across = 1200;
    assert_ok(ctx, pc_synth_torus_system(&system, ctx, PC_BLOCK_SCALAR, &torus));
    make_shared(&s, ctx, &system, 2, 1000);
    assert_true(s.share.spread >= 2);
    for (int m = 0; m < 2; m++) {
        const pc_row_order *order = &pc_share_of(&s.share, 0, m)->order;
        assert_true(order->count > 0.45 * system.row_count && order->count < 0.55 * system.row_count);
        assert_true(order->copies < 0.1 * order->count);
    }
    free_shared(&s, ctx);
    pc_system_free(&system, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(everything_is_dealt_out_once, make_context, free_context),
        cmocka_unit_test_setup_teardown(halves_are_fair, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
