/* Cells kept as polygons: joined where two lines meet twice, where a cell meets itself, where a line starts
 * and ends within a few cells; and upright in the end. */
#include "cellshape.h"
#include "mosaic_quads.h"
#include "param_testing.h"
#include "plane_param.h"
#include "polygraph.h"
#include "reconstruct.h"
#include "surface_testing.h"

static pc_index count_corners(const pc_mosaic *m, pc_index cell) {
    pc_index count = 0, s = m->first[cell];
    do {
        count += !pc_mosaic_is_flat(m, s);
        s = m->next[s];
    } while (s != m->first[cell]);
    return count;
}

/* Cells that are no polygons: fewer than three corners, or a node twice. */
static pc_index count_spoiled(const pc_mosaic *m) {
    pc_index count = 0;
    for (pc_index c = 0; c < m->cell_count; c++)
        count += m->first[c] != PC_NONE && (count_corners(m, c) < 3 || pc_mosaic_is_pinched(m, c));
    return count;
}

static pc_index count_flat(const pc_mosaic *m) {
    pc_index count = 0;
    for (pc_index s = 0; s < 2 * m->arc_count; s++)
        count += m->tail[s] != PC_NONE && m->cell[s] != PC_NONE && pc_mosaic_is_flat(m, s);
    return count;
}

static void is_sound(pc_context *ctx, const pc_mosaic *m, int64_t chi, uint64_t seed) {
    pc_polymesh polygons;
    pc_index *face_cell;
    if (pc_mosaic_check(m, ctx) != PC_OK)
        fail_msg("seed %llu: %s", (unsigned long long)seed, pc_context_message(ctx));
    assert_ok(ctx, pc_mosaic_polygons(&polygons, &face_cell, ctx, m));
    (void)is_manifold(ctx, &polygons, chi, seed);
    for (pc_index f = 0; f < polygons.face_count; f++)
        assert_true(m->first[face_cell[f]] != PC_NONE);
    pc_free(ctx, face_cell);
    pc_polymesh_free(&polygons, ctx);
}

/* ---- planes whose map is known ---- */

typedef struct bench {
    shape s;
    plane_param p;
    pc_layout layout;
} bench;

/* Six by five periods. The map may be torn where a cut ends at a dislocation: edges across it jump a period,
 * which becomes a shift. */
static void make_plane(bench *b, pc_context *ctx,
                       void (*map)(double *s, double *t, double x, double y, void *), void *user,
                       uint64_t seed) {
    double *periods;
    pc_layout_stats stats;
    *b = (bench){0};
    assert_ok(ctx, pc_synth_plane(&b->s.mesh, ctx, 6, 5, 96, 80));
    assert_ok(ctx, pc_synth_shuffle(&b->s.mesh, ctx, seed));
    measure_shape(&b->s, ctx);
    const pc_mesh *mesh = &b->s.mesh;
    assert_ok(ctx, pc_new(&periods, ctx, 2 * (size_t)mesh->vertex_count));
    for (size_t v = 0; v < mesh->vertex_count; v++)
        map(periods + 2 * v, periods + 2 * v + 1, mesh->position[3 * v], mesh->position[3 * v + 1], user);
    make_plane_param(&b->p, ctx, mesh, periods, seed);
    for (pc_index h = 0; h < 3 * mesh->face_count; h++) {
        pc_index i = pc_tail(mesh, h), j = pc_head(mesh, h);
        int64_t across = b->p.global[j].s - b->p.global[i].s;
        pc_point2 whole = {across > PC_PERIOD / 2 ? -1 : across < -PC_PERIOD / 2 ? 1 : 0, 0};
        pc_point2 own = pc_point2_turned(whole, b->p.frame[i]);
        b->p.param.shift[2 * (size_t)h] += (int32_t)own.s;
        b->p.param.shift[2 * (size_t)h + 1] += (int32_t)own.t;
    }
    pc_reconstruct_flags(&b->p.param, mesh);
    assert_ok(ctx, pc_param_check(&b->p.param, ctx, mesh, &b->s.adjacency));
    assert_ok(ctx, pc_layout_make(&b->layout, &stats, ctx, mesh, &b->p.param));
    pc_free(ctx, periods);
}

static void free_bench(bench *b, pc_context *ctx) {
    pc_layout_free(&b->layout, ctx);
    free_plane_param(&b->p, ctx);
    free_shape(&b->s, ctx);
}

/* A line more between two dislocations, `way` apart. */
typedef struct pair {
    double x, y, way;
} pair;

static void torn(double *s, double *t, double x, double y, void *user) {
    const pair *p = user;
    double below = atan2(x - p->x, y - p->y), above = atan2(x - p->x, y - p->y - p->way);
    *s = x + (below - above) / (2 * PC_PI);
    *t = y;
}

static void short_lines_are_dropped(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 4; seed++) {
        bench b;
        pc_mosaic m;
        pc_index gone;
        pair p = {2.8 + 0.05 * (double)seed, 1.37, 1.8 + 0.2 * (double)seed};
        make_plane(&b, ctx, torn, &p, seed);
        assert_ok(ctx, pc_mosaic_make(&m, ctx, &b.layout));
        is_sound(ctx, &m, 1, seed);
        if (count_flat(&m) != 2) fail_msg("seed %d: %u T-junctions", (int)seed, count_flat(&m));
        assert_ok(ctx, pc_mosaic_drop_lines(&m, &gone, ctx, 8, 1.01));
        assert_int_equal(gone, 0);
        assert_ok(ctx, pc_mosaic_drop_lines(&m, &gone, ctx, 8, 3));
        if (gone != 1 || count_flat(&m) != 0)
            fail_msg("seed %d: %u lines dropped, %u T-junctions left", (int)seed, gone, count_flat(&m));
        is_sound(ctx, &m, 1, seed);
        pc_mosaic_free(&m, ctx);
        free_bench(&b, ctx);
    }
}

enum { WRINKLES = 5 };

typedef struct wrinkles {
    double x[WRINKLES], y[WRINKLES], height[WRINKLES], width[WRINKLES];
} wrinkles;

/* Folds over at every wrinkle: lines of the two families meet two times there. */
static void wrinkled(double *s, double *t, double x, double y, void *user) {
    const wrinkles *w = user;
    double lift = 0;
    for (int i = 0; i < WRINKLES; i++) {
        double r = hypot(x - w->x[i], y - w->y[i]) / w->width[i];
        lift += w->height[i] * exp(-r * r);
    }
    *s = x + 0.3 * lift;
    *t = y + lift;
}

static wrinkles some_wrinkles(uint64_t seed) {
    wrinkles w;
    pc_random random = {seed * 1000 + 1};
    for (int i = 0; i < WRINKLES; i++) {
        w.x[i] = 1 + 4 * pc_random_uniform(&random), w.y[i] = 1 + 3 * pc_random_uniform(&random);
        w.height[i] = 0.5 + pc_random_uniform(&random), w.width[i] = 0.3 + 0.2 * pc_random_uniform(&random);
    }
    return w;
}

/* No face of what is written is upside down, without area or without corners. */
static void stands_upright(pc_context *ctx, const bench *b, uint64_t seed) {
    pc_polymesh quads;
    pc_mosaic_quads_stats stats;
    pc_ground ground;
    uint8_t *folded;
    assert_ok(ctx, pc_ground_make(&ground, ctx, &b->s.mesh, &b->s.adjacency));
    assert_ok(ctx, pc_mosaic_quads(&quads, &folded, &stats, ctx, &b->layout, &ground));
    pc_ground_free(&ground, ctx);
    (void)is_manifold(ctx, &quads, 1, seed);
    for (pc_index f = 0; f < quads.face_count; f++) {
        pc_index corners = pc_cell_corners(NULL, 0, &quads, f);
        double area = pc_face_normal(&quads, f).z;
        if (folded[f] || corners < 3 || area < 1e-6)
            fail_msg("seed %d: face %u has %u corners, area %g", (int)seed, f, corners, area);
    }
    pc_free(ctx, folded);
    pc_polymesh_free(&quads, ctx);
}

static void slivers_are_joined(void **state) {
    pc_context *ctx = *state;
    pc_index met = 0, left = 0;
    for (uint64_t seed = 0; seed < 16; seed++) {
        bench b;
        pc_mosaic m;
        wrinkles w = some_wrinkles(seed);
        make_plane(&b, ctx, wrinkled, &w, seed);
        assert_ok(ctx, pc_mosaic_make(&m, ctx, &b.layout));
        is_sound(ctx, &m, 1, seed);
        met += count_spoiled(&m);
        pc_mosaic_mend(&m);
        is_sound(ctx, &m, 1, seed);
        left += count_spoiled(&m);
        pc_mosaic_free(&m, ctx);
        stands_upright(ctx, &b, seed);
        free_bench(&b, ctx);
    }
    /* Few are round enough to stay, their sides' middles as corners. */
    if (met < 10 || 5 * left > met) fail_msg("of %u cells that are no polygons %u are left", met, left);
}

/* ---- joins of any cells, wherever they are ---- */

static void joins_keep_the_surface(void **state) {
    pc_context *ctx = *state;
    pc_device *host = open_host(ctx);
    for (int kind = 1; kind < SHAPE_KINDS; kind += 2) {
        shape s = {0};
        pc_param param;
        pc_param_stats stats;
        pc_layout layout;
        pc_layout_stats layout_stats;
        pc_mosaic m;
        pc_polygraph scan;
        pc_random random = {(uint64_t)kind};
        pc_param_options options = PC_PARAM_DEFAULTS;
        make_mesh(&s.mesh, ctx, kind, 5);
        finish_shape(&s, ctx, host);
        options.period_length = 3 * s.longest_edge;
        assert_ok(ctx,
                  pc_param_make(&param, &stats, ctx, host, &s.mesh, &s.adjacency, &s.field, NULL, &options));
        assert_ok(ctx, pc_layout_make(&layout, &layout_stats, ctx, &s.mesh, &param));
        assert_ok(ctx, pc_polygraph_of_mesh(&scan, ctx, &s.mesh));
        assert_ok(ctx, pc_mosaic_make(&m, ctx, &layout));
        for (int round = 0; round < 4; round++) {
            is_sound(ctx, &m, scan.count.chi, (uint64_t)kind);
            for (pc_index i = 0; i < m.arc_count / 16; i++) {
                pc_index side = (pc_index)(pc_random_next(&random) % (2 * m.arc_count));
                if (m.tail[side] == PC_NONE || m.cell[side] == PC_NONE || m.cell[side ^ 1] == PC_NONE)
                    continue;
                (void)pc_mosaic_join(&m, m.cell[side], m.cell[side ^ 1]);
            }
        }
        pc_mosaic_mend(&m);
        is_sound(ctx, &m, scan.count.chi, (uint64_t)kind);
        pc_mosaic_free(&m, ctx);
        pc_polygraph_free(&scan, ctx);
        pc_layout_free(&layout, ctx);
        pc_param_free(&param, ctx);
        free_shape(&s, ctx);
    }
    pc_device_close(host, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(short_lines_are_dropped, make_context, free_context),
        cmocka_unit_test_setup_teardown(slivers_are_joined, make_context, free_context),
        cmocka_unit_test_setup_teardown(joins_keep_the_surface, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
