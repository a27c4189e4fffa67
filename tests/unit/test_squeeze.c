/* Regions that get far less room than they have on the scan are marked, others are not. */
#include "plane_param.h"
#include "squeeze.h"
#include "synth.h"
#include <math.h>

enum { SIDE = 16, STEPS = 80 };

typedef struct bench {
    pc_mesh mesh;
    pc_adjacency adjacency;
    pc_edge_rows rows;
    plane_param p;
    uint8_t *mark;
    pc_index count;
} bench;

static double from_centre(const pc_mesh *mesh, size_t v) {
    return hypot(mesh->position[3 * v] - SIDE / 2.0, mesh->position[3 * v + 1] - SIDE / 2.0);
}

/* One period per unit of length; within 2.5 of the centre lengths are `inner` times as large, and what is
 * missing is made up for up to 5. */
static void make_bench(bench *b, pc_context *ctx, double inner, uint64_t seed) {
    double *periods;
    assert_ok(ctx, pc_synth_plane(&b->mesh, ctx, SIDE, SIDE, STEPS, STEPS));
    assert_ok(ctx, pc_adjacency_make(&b->adjacency, ctx, &b->mesh));
    assert_ok(ctx, pc_edge_rows_make(&b->rows, ctx, &b->mesh, &b->adjacency));
    assert_ok(ctx, pc_new(&b->mark, ctx, b->mesh.vertex_count));
    assert_ok(ctx, pc_new(&periods, ctx, 2 * (size_t)b->mesh.vertex_count));
    for (size_t v = 0; v < b->mesh.vertex_count; v++) {
        double r = from_centre(&b->mesh, v);
        double wanted = r < 2.5 ? inner * r : r < 5 ? 2.5 * inner + (r - 2.5) * (2 - inner) : r;
        for (size_t k = 0; k < 2; k++)
            periods[2 * v + k] = r > 0 ? (b->mesh.position[3 * v + k] - SIDE / 2.0) * wanted / r : 0;
    }
    make_plane_param(&b->p, ctx, &b->mesh, periods, seed);
    assert_ok(ctx, pc_param_check(&b->p.param, ctx, &b->mesh, &b->adjacency));
    pc_free(ctx, periods);
}

static void free_bench(bench *b, pc_context *ctx) {
    pc_mesh_free(&b->mesh, ctx);
    pc_adjacency_free(&b->adjacency, ctx);
    pc_edge_rows_free(&b->rows, ctx);
    free_plane_param(&b->p, ctx);
    pc_free(ctx, b->mark);
}

static void mark(bench *b, pc_context *ctx, const double *scale, double least) {
    pc_squeeze squeeze;
    assert_ok(ctx, pc_squeeze_make(&squeeze, ctx, &b->p.param, &b->mesh, &b->rows, scale));
    assert_ok(ctx, pc_squeeze_mark(b->mark, &b->count, ctx, &squeeze, &b->p.param, &b->mesh, least));
    pc_squeeze_free(&squeeze, ctx);
}

static void even_ones_are_not_marked(void **state) {
    pc_context *ctx = *state;
    bench b;
    make_bench(&b, ctx, 1, 4);
    mark(&b, ctx, NULL, 0.9);
    assert_int_equal(b.count, 0);
    for (size_t v = 0; v < b.mesh.vertex_count; v++)
        assert_int_equal(b.mark[v], 0);
    free_bench(&b, ctx);
}

static void a_squeezed_disk_is_marked(void **state) {
    pc_context *ctx = *state;
    bench b;
    make_bench(&b, ctx, 0.2, 5); /* a twenty-fifth of the area */
    b.mark[0] = 1;
    mark(&b, ctx, NULL, 0.3);
    pc_index marked = 0;
    for (size_t v = 1; v < b.mesh.vertex_count; v++) {
        double r = from_centre(&b.mesh, v);
        if (r < 2) assert_int_equal(b.mark[v], 1);
        if (r > 4.5) assert_int_equal(b.mark[v], 0);
        marked += b.mark[v];
    }
    assert_int_equal(b.count, marked);
    assert_int_equal(b.mark[0], 1);
    mark(&b, ctx, NULL, 0.3); /* nothing is new */
    assert_int_equal(b.count, 0);
    free_bench(&b, ctx);
}

/* Finer cells are asked for everywhere, and not there. */
static void scales_count(void **state) {
    pc_context *ctx = *state;
    bench b;
    double *scale;
    make_bench(&b, ctx, 1, 6);
    assert_ok(ctx, pc_new(&scale, ctx, b.mesh.vertex_count));
    for (size_t v = 0; v < b.mesh.vertex_count; v++)
        scale[v] = 3;
    mark(&b, ctx, scale, 0.3);
    assert_int_equal(b.count, b.mesh.vertex_count);
    pc_free(ctx, scale);
    free_bench(&b, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(even_ones_are_not_marked, make_context, free_context),
        cmocka_unit_test_setup_teardown(a_squeezed_disk_is_marked, make_context, free_context),
        cmocka_unit_test_setup_teardown(scales_count, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
