/* Graph, order, parts and halos: permutations, checks, and what they are for. */
#include "halo.h"
#include "order.h"
#include "random.h"
#include "synth.h"
#include "testing.h"
#include <signal.h>
#include <stdlib.h>

typedef struct shape {
    pc_mesh mesh;
    pc_adjacency adjacency;
    pc_graph graph;
} shape;

static void shape_finish(shape *s, pc_context *ctx) {
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->mesh));
    assert_ok(ctx, pc_graph_make(&s->graph, ctx, &s->mesh, &s->adjacency));
    assert_ok(ctx, pc_graph_check(&s->graph, ctx));
}

static void shape_free(shape *s, pc_context *ctx) {
    pc_graph_free(&s->graph, ctx);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->mesh, ctx);
}

static void shuffle(pc_index *list, pc_index count, pc_random *random) {
    for (pc_index i = 0; i < count; i++)
        list[i] = i;
    for (pc_index i = count; i > 1; i--) {
        pc_index j = (pc_index)(pc_random_next(random) % i), swap = list[i - 1];
        list[i - 1] = list[j], list[j] = swap;
    }
}

/* Several copies of a random shape, vertices and faces in random order, some vertices isolated. */
static void make_shape(shape *s, pc_context *ctx, uint64_t seed) {
    pc_random random = {pc_hash64(seed)};
    pc_mesh one;
    pc_index copies = 1 + (pc_index)(pc_random_next(&random) % 3),
             extra = (pc_index)(pc_random_next(&random) % 3);
    pc_index n = 3 + (pc_index)(pc_random_next(&random) % 20),
             m = 3 + (pc_index)(pc_random_next(&random) % 20);
    pc_index *place, *order;
    switch (random.state % 3) {
    case 0:
        assert_ok(ctx, pc_synth_torus(&one, ctx, 2, 1, n, m));
        break;
    case 1:
        assert_ok(ctx, pc_synth_plane(&one, ctx, 1, 1, n, m));
        break;
    default:
        assert_ok(ctx, pc_synth_cylinder(&one, ctx, 1, n, m));
        break;
    }
    pc_index vertices = copies * one.vertex_count + extra, faces = copies * one.face_count;
    assert_ok(ctx, pc_mesh_make(&s->mesh, ctx, vertices, faces));
    assert_ok(ctx, pc_new(&place, ctx, vertices));
    assert_ok(ctx, pc_new(&order, ctx, faces));
    shuffle(place, vertices, &random);
    shuffle(order, faces, &random);
    for (pc_index v = 0; v + extra < vertices; v++)
        for (pc_index k = 0; k < 3; k++)
            s->mesh.position[3 * place[v] + k] = one.position[3 * (v % one.vertex_count) + k];
    for (pc_index f = 0; f < faces; f++)
        for (pc_index k = 0; k < 3; k++)
            s->mesh.triangle[3 * order[f] + k] =
                place[f / one.face_count * one.vertex_count + one.triangle[3 * (f % one.face_count) + k]];
    pc_free(ctx, place);
    pc_free(ctx, order);
    pc_mesh_free(&one, ctx);
    shape_finish(s, ctx);
}

static void order_is_a_permutation_that_keeps_the_mesh(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        shape s, renumbered;
        pc_order order;
        make_shape(&s, ctx, seed);
        assert_ok(ctx, pc_order_make(&order, ctx, &s.mesh, &s.graph));
        assert_ok(ctx, pc_order_check(&order, ctx));
        assert_ok(ctx, pc_order_apply(&renumbered.mesh, ctx, &order, &s.mesh));
        shape_finish(&renumbered, ctx);
        pc_index last = 0;
        for (pc_index f = 0; f < s.mesh.face_count; f++) {
            const pc_index *t = renumbered.mesh.triangle + 3 * f;
            pc_index least = t[0] < t[1] ? t[0] : t[1];
            least = t[2] < least ? t[2] : least;
            if (least < last) fail_msg("seed %llu: face %u is out of order", (unsigned long long)seed, f);
            last = least;
            for (pc_index k = 0; k < 3; k++) {
                pc_index old = s.mesh.triangle[3 * order.face_old[f] + k];
                assert_int_equal(t[k], order.vertex_new[old]);
                assert_memory_equal(renumbered.mesh.position + 3 * t[k], s.mesh.position + 3 * old, 24);
            }
        }
        assert_true(pc_order_bandwidth(&renumbered.graph).largest <= pc_order_bandwidth(&s.graph).largest);
        pc_order_free(&order, ctx);
        shape_free(&s, ctx);
        shape_free(&renumbered, ctx);
    }
}

/* A strip of n x 5 squares has bandwidth of about 7, wherever its vertices stood. */
static void bandwidth_of_a_strip_is_its_width(void **state) {
    pc_context *ctx = *state;
    shape s, renumbered;
    pc_order order;
    assert_ok(ctx, pc_synth_plane(&s.mesh, ctx, 1, 1, 300, 5));
    shape_finish(&s, ctx);
    assert_ok(ctx, pc_order_make(&order, ctx, &s.mesh, &s.graph));
    assert_ok(ctx, pc_order_apply(&renumbered.mesh, ctx, &order, &s.mesh));
    shape_finish(&renumbered, ctx);
    assert_in_range(pc_order_bandwidth(&renumbered.graph).largest, 6, 12);
    pc_order_free(&order, ctx);
    shape_free(&s, ctx);
    shape_free(&renumbered, ctx);
}

static void parts_and_halos_pass_their_checks(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        const pc_index counts[5] = {1, 2, 7, 64, 1000};
        shape s;
        make_shape(&s, ctx, seed);
        for (int i = 0; i < 5; i++) {
            pc_parts parts;
            pc_halo halo;
            assert_ok(ctx, pc_parts_make(&parts, ctx, &s.graph, counts[i]));
            assert_ok(ctx, pc_parts_check(&parts, ctx, &s.graph));
            assert_ok(ctx, pc_halo_make(&halo, ctx, &s.graph, &parts));
            assert_ok(ctx, pc_halo_check(&halo, ctx, &s.graph, &parts));
            if (counts[i] == 1) assert_int_equal(pc_halo_count(&halo, 0), 0);
            pc_halo_free(&halo, ctx);
            pc_parts_free(&parts, ctx);
        }
        shape_free(&s, ctx);
    }
}

static void parts_are_balanced_and_repeatable(void **state) {
    pc_context *ctx = *state;
    shape s;
    pc_parts parts, again;
    pc_halo halo;
    assert_ok(ctx, pc_synth_sphere(&s.mesh, ctx, 40));
    shape_finish(&s, ctx);
    assert_ok(ctx, pc_parts_make(&parts, ctx, &s.graph, 8));
    (void)rand(); /* METIS must not lean on its state */ /* NOLINT(cert-msc30-c,cert-msc50-cpp) */
    assert_ok(ctx, pc_parts_make(&again, ctx, &s.graph, 8));
    assert_memory_equal(parts.vertex_part, again.vertex_part, parts.vertex_count * sizeof *parts.vertex_part);
    assert_ok(ctx, pc_halo_make(&halo, ctx, &s.graph, &parts));
    for (pc_index p = 0; p < 8; p++) {
        assert_in_range(pc_halo_owned_count(&halo, p), s.mesh.vertex_count / 10, s.mesh.vertex_count / 6);
        assert_in_range(pc_halo_count(&halo, p), 1, s.mesh.vertex_count / 16);
    }
    pc_halo_free(&halo, ctx);
    pc_parts_free(&parts, ctx);
    pc_parts_free(&again, ctx);
    assert_int_equal(pc_parts_make(&parts, ctx, &s.graph, 0), PC_E_USAGE);
    shape_free(&s, ctx);
}

/* A wrong entry in any list is found. */
static void halo_check_finds_errors(void **state) {
    pc_context *ctx = *state;
    shape s;
    pc_parts parts;
    pc_halo halo;
    assert_ok(ctx, pc_synth_torus(&s.mesh, ctx, 2, 1, 20, 10));
    shape_finish(&s, ctx);
    assert_ok(ctx, pc_parts_make(&parts, ctx, &s.graph, 4));
    assert_ok(ctx, pc_halo_make(&halo, ctx, &s.graph, &parts));
    pc_index *const lists[6] = {halo.owned,      halo.local,   halo.halo,
                                halo.halo_owner, halo.send_to, halo.send_local};
    for (int i = 0; i < 6; i++) {
        lists[i][0]++;
        assert_int_equal(pc_halo_check(&halo, ctx, &s.graph, &parts), PC_E_BUG);
        lists[i][0]--;
    }
    pc_context_clear_message(ctx);
    assert_ok(ctx, pc_halo_check(&halo, ctx, &s.graph, &parts));
    pc_halo_free(&halo, ctx);
    pc_parts_free(&parts, ctx);
    shape_free(&s, ctx);
}

static void on_term(int number, siginfo_t *info, void *more) {
    (void)number, (void)info, (void)more;
}

static void signal_handlers_stay(void **state) {
    pc_context *ctx = *state;
    struct sigaction mine = {.sa_sigaction = on_term, .sa_flags = SA_SIGINFO | SA_RESTART}, before, after;
    shape s;
    pc_parts parts;
    (void)sigemptyset(&mine.sa_mask);
    (void)sigaddset(&mine.sa_mask, SIGINT);
    assert_int_equal(sigaction(SIGTERM, &mine, &before), 0);
    assert_ok(ctx, pc_synth_sphere(&s.mesh, ctx, 10));
    shape_finish(&s, ctx);
    assert_ok(ctx, pc_parts_make(&parts, ctx, &s.graph, 3));
    assert_int_equal(sigaction(SIGTERM, &before, &after), 0);
    assert_true(after.sa_sigaction == on_term);
    assert_true(after.sa_flags & SA_SIGINFO && after.sa_flags & SA_RESTART);
    assert_int_equal(sigismember(&after.sa_mask, SIGINT), 1);
    pc_parts_free(&parts, ctx);
    shape_free(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(order_is_a_permutation_that_keeps_the_mesh, make_context,
                                        free_context),
        cmocka_unit_test_setup_teardown(bandwidth_of_a_strip_is_its_width, make_context, free_context),
        cmocka_unit_test_setup_teardown(parts_and_halos_pass_their_checks, make_context, free_context),
        cmocka_unit_test_setup_teardown(parts_are_balanced_and_repeatable, make_context, free_context),
        cmocka_unit_test_setup_teardown(halo_check_finds_errors, make_context, free_context),
        cmocka_unit_test_setup_teardown(signal_handlers_stay, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
