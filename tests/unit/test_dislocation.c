/* Dislocations put into a parameterization without any find each other, or a border, and vanish: what is left
 * differs from the first one by whole periods at vertices only. */
#include "dislocation.h"
#include "plane_param.h"
#include "reconstruct.h"
#include "synth.h"
#include "synth_wear.h"

enum { NX = 40, NY = 30, PATH = 7 };

typedef struct bench {
    pc_mesh mesh;
    pc_adjacency adjacency;
    plane_param p;
    pc_index cancelled;
    uint64_t seed;
} bench;

/* Four by three units of 1.3 periods, turned at random, the faces in random order. */
static void make_bench(bench *b, pc_context *ctx, uint64_t seed) {
    const double c = 1.3 * cos((double)seed), s = 1.3 * sin((double)seed), a[4] = {c, s, -s, c};
    b->seed = seed;
    b->cancelled = PC_NONE;
    assert_ok(ctx, pc_synth_plane(&b->mesh, ctx, 4, 3, NX, NY));
    assert_ok(ctx, pc_synth_shuffle(&b->mesh, ctx, seed));
    assert_ok(ctx, pc_adjacency_make(&b->adjacency, ctx, &b->mesh));
    make_linear_param(&b->p, ctx, &b->mesh, a, seed);
    assert_ok(ctx, pc_param_check(&b->p.param, ctx, &b->mesh, &b->adjacency));
}

static void free_bench(bench *b, pc_context *ctx) {
    free_plane_param(&b->p, ctx);
    pc_adjacency_free(&b->adjacency, ctx);
    pc_mesh_free(&b->mesh, ctx);
}

static pc_vec3 centroid(const bench *b, pc_index f) {
    const pc_index *t = b->mesh.triangle + 3 * (size_t)f;
    pc_vec3 sum = pc_add(pc_vec3_at(b->mesh.position, t[0]), pc_vec3_at(b->mesh.position, t[1]));
    return pc_scale(1.0 / 3, pc_add(sum, pc_vec3_at(b->mesh.position, t[2])));
}

static pc_index face_at(const bench *b, double x, double y) {
    pc_index best = 0;
    for (pc_index f = 1; f < b->mesh.face_count; f++)
        if (pc_distance(centroid(b, f), (pc_vec3){x, y, 0}) <
            pc_distance(centroid(b, best), (pc_vec3){x, y, 0}))
            best = f;
    return best;
}

/* Across half-edge h the plane jumps by `burgers` whole periods. */
static void add_jump(bench *b, pc_index h, pc_point2 burgers) {
    pc_param *param = &b->p.param;
    pc_point2 own = pc_point2_turned(burgers, b->p.frame[pc_tail(&b->mesh, h)]);
    param->shift[2 * (size_t)h] += (int32_t)own.s;
    param->shift[2 * (size_t)h + 1] += (int32_t)own.t;
    pc_index twin = b->adjacency.twin[h];
    if (twin == PC_NONE) return;
    pc_transition g = pc_transition_inverse(pc_transition_of(param, h));
    param->shift[2 * (size_t)twin] = (int32_t)g.a, param->shift[2 * (size_t)twin + 1] = (int32_t)g.b;
}

/* A pair of opposite dislocations: at `from`, and `steps` faces farther on along the direction `turn`. Gives
 * the other face. */
static pc_index put_pair(bench *b, pc_index from, double turn, int steps, pc_point2 burgers) {
    pc_index f = from;
    for (int i = 0; i < steps; i++) {
        pc_index best = PC_NONE;
        double farthest = -INFINITY;
        for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
            if (b->adjacency.twin[h] == PC_NONE) continue;
            pc_vec3 to = centroid(b, b->adjacency.twin[h] / 3), step = pc_sub(to, centroid(b, from));
            double along = step.x * cos(turn) + step.y * sin(turn);
            if (along > farthest) farthest = along, best = h;
        }
        add_jump(b, best, burgers);
        f = b->adjacency.twin[best] / 3;
    }
    pc_reconstruct_flags(&b->p.param, &b->mesh);
    return f;
}

static pc_index count_dislocations(const bench *b) {
    pc_index count = 0;
    for (pc_index f = 0; f < b->mesh.face_count; f++)
        count += b->p.param.singular[f] == PC_DISLOCATION;
    return count;
}

static void cancel(bench *b, pc_context *ctx, const uint8_t *guarded, double reach) {
    assert_ok(ctx, pc_dislocations_cancel(&b->p.param, &b->cancelled, NULL, ctx, &b->mesh, &b->adjacency,
                                          guarded, reach));
}

/* Where each vertex is seen over a tree of edges, less where it was, is whole periods; with those as its new
 * coordinates every edge is what it was in the plane. */
static void becomes_the_plane_again(bench *b, pc_context *ctx) {
    pc_param *param = &b->p.param;
    pc_index n = b->mesh.vertex_count, *queue, end = 1;
    uint8_t *seen;
    assert_ok(ctx, pc_new(&queue, ctx, n));
    assert_ok(ctx, pc_new(&seen, ctx, n));
    seen[queue[0]] = 1;
    for (int pass = 0; pass < 2; pass++)
        for (pc_index q = 0; q < end; q++) {
            pc_index first = b->adjacency.vertex_half[queue[q]];
            for (pc_index h = first; h != PC_NONE;) {
                size_t i = queue[q], j = pc_head(&b->mesh, h);
                pc_point2 step = {b->p.global[j].s - b->p.global[i].s, b->p.global[j].t - b->p.global[i].t};
                step = pc_point2_turned(step, b->p.frame[i]);
                pc_point2 place = {param->coordinate[2 * i] + step.s, param->coordinate[2 * i + 1] + step.t};
                place = pc_transition_apply(pc_transition_inverse(pc_transition_of(param, h)), place);
                int64_t ds = place.s - param->coordinate[2 * j], dt = place.t - param->coordinate[2 * j + 1];
                if (ds % PC_PERIOD || dt % PC_PERIOD || (seen[j] && pass && (ds || dt)))
                    fail_msg("seed %llu: vertex %zu is not where it was", (unsigned long long)b->seed, j);
                if (!seen[j]) {
                    param->coordinate[2 * j] = (int32_t)place.s,
                                          param->coordinate[2 * j + 1] = (int32_t)place.t;
                    seen[j] = 1, queue[end++] = (pc_index)j;
                }
                h = pc_turn_ccw(&b->adjacency, h);
                if (h == first) break;
            }
        }
    assert_int_equal(end, n);
    pc_free(ctx, queue);
    pc_free(ctx, seen);
    pc_reconstruct_flags(param, &b->mesh);
    for (pc_index f = 0; f < b->mesh.face_count; f++)
        assert_int_equal(param->singular[f], PC_REGULAR);
    assert_ok(ctx, pc_param_check(param, ctx, &b->mesh, &b->adjacency));
}

static pc_point2 some_burgers(pc_random *random) {
    static const pc_point2 some[] = {{1, 0}, {0, -1}, {-1, 0}, {0, 1}, {1, 1}, {-2, 1}};
    return some[pc_random_next(random) % 6];
}

static void pairs_vanish(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 40; seed++) {
        bench b;
        pc_random random = {seed};
        make_bench(&b, ctx, seed);
        pc_index from = face_at(&b, 1.5 + pc_random_uniform(&random), 1 + pc_random_uniform(&random));
        put_pair(&b, from, 6.3 * pc_random_uniform(&random), PATH, some_burgers(&random));
        assert_int_equal(count_dislocations(&b), 2);
        cancel(&b, ctx, NULL, 0.05); /* they do not reach each other */
        assert_true(b.cancelled == 0 && count_dislocations(&b) == 2);
        cancel(&b, ctx, NULL, 2);
        if (b.cancelled != 2 || count_dislocations(&b))
            fail_msg("seed %llu: %u cancelled, %u left", (unsigned long long)seed, b.cancelled,
                     count_dislocations(&b));
        becomes_the_plane_again(&b, ctx);
        free_bench(&b, ctx);
    }
}

/* Many pairs across each other: all vanish, by pairs or over the border. */
static void crowds_vanish(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        bench b;
        pc_random random = {seed};
        make_bench(&b, ctx, seed);
        for (int i = 0; i < 12; i++) {
            pc_index from = face_at(&b, 1 + 2 * pc_random_uniform(&random), 1 + pc_random_uniform(&random));
            put_pair(&b, from, 6.3 * pc_random_uniform(&random), 1 + i % PATH, some_burgers(&random));
        }
        pc_index before = count_dislocations(&b);
        cancel(&b, ctx, NULL, 10);
        if (before < 2 || b.cancelled != before || count_dislocations(&b))
            fail_msg("seed %llu: %u of %u cancelled, %u left", (unsigned long long)seed, b.cancelled, before,
                     count_dislocations(&b));
        becomes_the_plane_again(&b, ctx);
        free_bench(&b, ctx);
    }
}

static void guarded_ones_stay(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 10; seed++) {
        bench b;
        uint8_t *guarded;
        pc_random random = {seed};
        make_bench(&b, ctx, seed);
        assert_ok(ctx, pc_new(&guarded, ctx, b.mesh.vertex_count));
        pc_index from = face_at(&b, 2, 1.5);
        pc_index to = put_pair(&b, from, 6.3 * pc_random_uniform(&random), PATH, some_burgers(&random));
        guarded[b.mesh.triangle[3 * (size_t)to + seed % 3]] = 1;
        cancel(&b, ctx, guarded, 0.8); /* the border is farther away */
        assert_int_equal(b.cancelled, 0);
        assert_int_equal(count_dislocations(&b), 2);
        assert_true(b.p.param.singular[from] == PC_DISLOCATION && b.p.param.singular[to] == PC_DISLOCATION);
        pc_free(ctx, guarded);
        free_bench(&b, ctx);
    }
}

/* With what an earlier call found for the same crowd, less guarded, comes what comes without. */
static void known_searches_change_nothing(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        bench b;
        pc_random random = {seed};
        pc_dislocation_plans *known = NULL;
        uint8_t *guarded;
        int32_t *start, *fresh;
        make_bench(&b, ctx, seed);
        for (int i = 0; i < 12; i++) {
            pc_index from = face_at(&b, 1 + 2 * pc_random_uniform(&random), 1 + pc_random_uniform(&random));
            put_pair(&b, from, 6.3 * pc_random_uniform(&random), 1 + i % PATH, some_burgers(&random));
        }
        size_t shifts = 6 * (size_t)b.mesh.face_count;
        assert_ok(ctx, pc_new(&guarded, ctx, b.mesh.vertex_count));
        assert_ok(ctx, pc_new(&start, ctx, shifts));
        assert_ok(ctx, pc_new(&fresh, ctx, shifts));
        memcpy(start, b.p.param.shift, shifts * sizeof *start);
        for (int call = 0; call < 3; call++) {
            pc_index cancelled;
            memcpy(b.p.param.shift, start, shifts * sizeof *start);
            pc_reconstruct_flags(&b.p.param, &b.mesh);
            cancel(&b, ctx, guarded, 0.7);
            memcpy(fresh, b.p.param.shift, shifts * sizeof *fresh);
            memcpy(b.p.param.shift, start, shifts * sizeof *start);
            pc_reconstruct_flags(&b.p.param, &b.mesh);
            assert_ok(ctx, pc_dislocations_cancel(&b.p.param, &cancelled, &known, ctx, &b.mesh, &b.adjacency,
                                                  guarded, 0.7));
            if (cancelled != b.cancelled || memcmp(fresh, b.p.param.shift, shifts * sizeof *fresh) != 0)
                fail_msg("seed %llu: call %d differs, %u and %u cancelled", (unsigned long long)seed, call,
                         b.cancelled, cancelled);
            for (int i = 0; i < 60; i++)
                guarded[pc_random_next(&random) % b.mesh.vertex_count] = 1;
        }
        pc_dislocation_plans_free(known, ctx);
        pc_free(ctx, guarded);
        pc_free(ctx, start);
        pc_free(ctx, fresh);
        free_bench(&b, ctx);
    }
}

/* One at a border, whose edge has a jump without a partner, leaves there. So does one some faces inside. */
static void borders_let_out(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        bench b;
        pc_random random = {seed};
        make_bench(&b, ctx, seed);
        pc_index rim = 0, f = face_at(&b, 4 * pc_random_uniform(&random), 0);
        for (pc_index h = 3 * f; h < 3 * f + 3; h++)
            if (b.adjacency.twin[h] == PC_NONE) rim = h;
        assert_true(b.adjacency.twin[rim] == PC_NONE);
        pc_point2 burgers = some_burgers(&random), back = {-burgers.s, -burgers.t};
        add_jump(&b, rim, burgers);
        pc_index inside = put_pair(&b, f, PC_PI / 2, (int)(seed % PATH), back);
        assert_int_equal(count_dislocations(&b), 1);
        assert_int_equal(b.p.param.singular[inside], PC_DISLOCATION);
        cancel(&b, ctx, NULL, 1);
        if (b.cancelled != 1 || count_dislocations(&b))
            fail_msg("seed %llu: %u cancelled, %u left", (unsigned long long)seed, b.cancelled,
                     count_dislocations(&b));
        becomes_the_plane_again(&b, ctx);
        free_bench(&b, ctx);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(pairs_vanish, make_context, free_context),
        cmocka_unit_test_setup_teardown(crowds_vanish, make_context, free_context),
        cmocka_unit_test_setup_teardown(guarded_ones_stay, make_context, free_context),
        cmocka_unit_test_setup_teardown(known_searches_change_nothing, make_context, free_context),
        cmocka_unit_test_setup_teardown(borders_let_out, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
