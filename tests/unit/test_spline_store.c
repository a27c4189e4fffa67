/* A spline from a file is the spline that was saved, bit for bit, and goes on as if it had never been away;
 * damaged files are refused. */
#include "adapt.h"
#include "insertion.h"
#include "python.h"
#include "random_quads.h"
#include "spline_store.h"
#include "synth.h"
#include "testing.h"

static char path[64];
static const pc_store_options options = {.force = true};
static const pc_tmesh_options defaults = PC_TMESH_DEFAULTS;

static int enter(void **state) {
    (void)state;
    (void)snprintf(path, sizeof path, "/tmp/percale-spline-store-%ld.h5", (long)getpid());
    return 0;
}

static int leave(void **state) {
    (void)state;
    return unlink(path);
}

/* Halves about one face of `rarity`. */
static void refine(pc_context *ctx, pc_tspline *spline, pc_random *random, int rarity) {
    uint8_t *wish;
    pc_closure_stats stats;
    assert_ok(ctx, pc_new(&wish, ctx, spline->mesh.face_count));
    for (pc_index f = 0; f < spline->mesh.face_count; f++)
        if (pc_random_uniform(random) * rarity < 1)
            wish[f] = (uint8_t)(1 + (int)(3 * pc_random_uniform(random)));
    assert_ok(ctx, pc_insertion_refine(spline, &stats, ctx, wish));
    pc_free(ctx, wish);
}

enum { TORUS, PLANE, SPHERE, FOLDED, KINDS };

/* With control points a little off, refined once. */
static pc_tspline make_spline(pc_context *ctx, int kind, uint64_t seed) {
    pc_random random = {seed};
    pc_tspline spline;
    pc_polymesh quads;
    switch (kind) {
    case TORUS:
        assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 1, 12, 8));
        break;
    case PLANE:
        assert_ok(ctx, pc_synth_quad_plane(&quads, ctx, 6, 4, 6, 5));
        break;
    case SPHERE:
        assert_ok(ctx, pc_synth_quad_sphere(&quads, ctx, 3));
        break;
    default:
        make_random_quads(&quads, ctx, seed, 4, 12);
        break;
    }
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    for (size_t i = 0; i < 3 * (size_t)spline.mesh.vertex_count; i++)
        spline.position[i] += 0.1 * pc_random_uniform(&random);
    pc_tspline_update(&spline);
    refine(ctx, &spline, &random, 12);
    pc_polymesh_free(&quads, ctx);
    return spline;
}

static void save(pc_context *ctx, const pc_tspline *spline) {
    pc_store *store;
    assert_ok(ctx, pc_store_create(&store, ctx, path, &options));
    assert_ok(ctx, pc_tspline_save(store, "spline", spline));
    assert_ok(ctx, pc_store_commit(&store));
}

static pc_status load(pc_tspline *spline, pc_context *ctx) {
    pc_store *store;
    assert_ok(ctx, pc_store_open(&store, ctx, path));
    pc_status status = pc_tspline_load(spline, store, "spline");
    pc_store_close(store);
    return status;
}

static void assert_same_mesh(const pc_tmesh *a, const pc_tmesh *b) {
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->half_count, b->half_count);
    assert_int_equal(a->face_count, b->face_count);
    for (size_t v = 0; v < a->vertex_count; v++) {
        const pc_tvertex *x = a->vertex + v, *y = b->vertex + v;
        assert_true(x->out == y->out && x->extraordinary == y->extraordinary && x->depth == y->depth);
    }
    for (size_t h = 0; h < a->half_count; h++) {
        const pc_thalf *x = a->half + h, *y = b->half + h;
        assert_true(x->tail == y->tail && x->next == y->next && x->prev == y->prev && x->twin == y->twin);
        assert_true(x->face == y->face && x->side == y->side);
        assert_memory_equal(&x->interval, &y->interval, sizeof x->interval);
        assert_memory_equal(&x->along, &y->along, sizeof x->along);
    }
    for (size_t f = 0; f < a->face_count; f++) {
        const pc_tface *x = a->face + f, *y = b->face + f;
        assert_true(x->first == y->first && x->root == y->root && x->ghost == y->ghost);
        assert_memory_equal(x->size, y->size, sizeof x->size);
        assert_memory_equal(x->origin, y->origin, sizeof x->origin);
    }
}

static void assert_same(const pc_tspline *a, const pc_tspline *b) {
    const pc_basis *x = &a->basis, *y = &b->basis;
    assert_same_mesh(&a->mesh, &b->mesh);
    assert_memory_equal(a->position, b->position, 3 * sizeof(double) * a->mesh.vertex_count);
    assert_int_equal(x->element_count, y->element_count);
    size_t points = x->start[x->element_count], coefficients = 0;
    assert_memory_equal(x->face_start, y->face_start, ((size_t)x->face_count + 1) * sizeof *x->face_start);
    assert_memory_equal(x->start, y->start, ((size_t)x->element_count + 1) * sizeof *x->start);
    assert_memory_equal(x->point, y->point, points * sizeof *x->point);
    for (pc_index e = 0; e < x->element_count; e++) {
        const pc_element *p = x->element + e, *q = y->element + e;
        assert_true(p->face == q->face && p->irregular == q->irregular && p->coefficient == q->coefficient);
        assert_memory_equal(p->low, q->low, sizeof p->low);
        assert_memory_equal(p->high, q->high, sizeof p->high);
        coefficients += (x->start[e + 1] - x->start[e]) * (p->irregular ? 16 : 8);
    }
    assert_memory_equal(x->coefficient, y->coefficient, coefficients * sizeof *x->coefficient);
    assert_memory_equal(a->bezier, b->bezier, 48 * sizeof(double) * x->element_count);
}

static void splines_come_back(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < KINDS; kind++) {
        pc_tspline spline = make_spline(ctx, kind, 40 + (uint64_t)kind), copy;
        save(ctx, &spline);
        assert_ok(ctx, load(&copy, ctx));
        assert_same(&spline, &copy);
        pc_tspline_free(&copy, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

static void refinement_goes_on(void **state) {
    pc_context *ctx = *state;
    for (int kind = 0; kind < KINDS; kind++) {
        pc_tspline spline = make_spline(ctx, kind, 50 + (uint64_t)kind), copy;
        save(ctx, &spline);
        assert_ok(ctx, load(&copy, ctx));
        for (uint64_t round = 0; round < 2; round++) {
            pc_random one = {round}, other = {round};
            refine(ctx, &spline, &one, 15);
            refine(ctx, &copy, &other, 15);
            assert_same(&spline, &copy);
        }
        pc_tspline_free(&copy, ctx);
        pc_tspline_free(&spline, ctx);
    }
}

static void fitting_goes_on(void **state) {
    pc_context *ctx = *state;
    pc_device *device;
    pc_mesh mesh;
    pc_adjacency adjacency;
    pc_target target;
    pc_polymesh quads;
    pc_tspline spline, copy;
    pc_adapt_options adapt = PC_ADAPT_DEFAULTS;
    pc_adapt_stats stats, again;
    assert_ok(ctx, pc_device_open(&device, ctx, "host"));
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 0.7, 60, 36));
    assert_ok(ctx, pc_adjacency_make(&adjacency, ctx, &mesh));
    assert_ok(ctx, pc_target_make(&target, ctx, &mesh, &adjacency));
    assert_ok(ctx, pc_synth_quad_torus(&quads, ctx, 2, 0.7, 10, 6));
    assert_ok(ctx, pc_tspline_make(&spline, ctx, &quads, &defaults));
    adapt.max_rounds = 1; /* out of reach of so few: a first half and a second */
    assert_int_equal(pc_adapt(&spline, &stats, ctx, device, &target, &adapt), PC_E_NOCONV);
    save(ctx, &spline);
    assert_ok(ctx, load(&copy, ctx));
    assert_int_equal(pc_adapt(&spline, &stats, ctx, device, &target, &adapt), PC_E_NOCONV);
    assert_int_equal(pc_adapt(&copy, &again, ctx, device, &target, &adapt), PC_E_NOCONV);
    assert_true(stats.accuracy.max == again.accuracy.max);
    assert_same(&spline, &copy);
    pc_tspline_free(&spline, ctx);
    pc_tspline_free(&copy, ctx);
    pc_polymesh_free(&quads, ctx);
    pc_target_free(&target, ctx);
    pc_adjacency_free(&adjacency, ctx);
    pc_mesh_free(&mesh, ctx);
    pc_device_close(device, ctx);
}

/* A dataset as bytes. */
typedef struct raw {
    const char *name;
    pc_store_type type;
    size_t size; /* of one number */
    size_t dims[2];
    uint8_t *data;
} raw;

static const raw kinds[] = {
    {.name = "position", .type = PC_STORE_F64, .size = 8, .dims = {0, 3}},
    {.name = "out", .type = PC_STORE_U32, .size = 4},
    {.name = "extraordinary", .type = PC_STORE_U8, .size = 1},
    {.name = "depth", .type = PC_STORE_U8, .size = 1},
    {.name = "tail", .type = PC_STORE_U32, .size = 4},
    {.name = "next", .type = PC_STORE_U32, .size = 4},
    {.name = "prev", .type = PC_STORE_U32, .size = 4},
    {.name = "twin", .type = PC_STORE_U32, .size = 4},
    {.name = "face", .type = PC_STORE_U32, .size = 4},
    {.name = "interval", .type = PC_STORE_F64, .size = 8},
    {.name = "along", .type = PC_STORE_F64, .size = 8},
    {.name = "side", .type = PC_STORE_U8, .size = 1},
    {.name = "first", .type = PC_STORE_U32, .size = 4},
    {.name = "size", .type = PC_STORE_F64, .size = 8, .dims = {0, 2}},
    {.name = "root", .type = PC_STORE_U32, .size = 4},
    {.name = "origin", .type = PC_STORE_F64, .size = 8, .dims = {0, 2}},
    {.name = "ghost", .type = PC_STORE_U8, .size = 1},
};
enum { ARRAYS = sizeof kinds / sizeof *kinds };

static size_t numbers(const raw *r) {
    return r->dims[0] * (r->dims[1] ? r->dims[1] : 1);
}

static const char *name_of(const raw *r) {
    static char name[64];
    (void)snprintf(name, sizeof name, "spline/%s", r->name);
    return name;
}

static void read_arrays(pc_context *ctx, raw list[ARRAYS]) {
    pc_store *store;
    assert_ok(ctx, pc_store_open(&store, ctx, path));
    for (int i = 0; i < ARRAYS; i++) {
        list[i] = kinds[i];
        list[i].dims[0] = PC_STORE_ANY;
        assert_ok(ctx, pc_store_get(&list[i].data, store, name_of(list + i), list[i].type,
                                    list[i].dims[1] ? 2 : 1, list[i].dims));
    }
    pc_store_close(store);
}

/* All but array `without`. */
static void write_arrays(pc_context *ctx, const raw list[ARRAYS], int without) {
    pc_store *store;
    assert_ok(ctx, pc_store_create(&store, ctx, path, &options));
    for (int i = 0; i < ARRAYS; i++)
        if (i != without)
            assert_ok(ctx, pc_store_put(store, name_of(list + i), list[i].type, list[i].dims[1] ? 2 : 1,
                                        list[i].dims, list[i].data, "1", "test"));
    assert_ok(ctx, pc_store_commit(&store));
}

static void free_arrays(pc_context *ctx, raw list[ARRAYS]) {
    for (int i = 0; i < ARRAYS; i++)
        pc_free(ctx, list[i].data);
}

static void missing_and_short_arrays_are_refused(void **state) {
    pc_context *ctx = *state;
    pc_tspline spline = make_spline(ctx, SPHERE, 60), copy;
    raw list[ARRAYS];
    save(ctx, &spline);
    pc_tspline_free(&spline, ctx);
    read_arrays(ctx, list);
    for (int i = 0; i < ARRAYS; i++)
        for (int way = 0; way < 2; way++) {
            if (way == 1 && list[i].size == 1) continue; /* one row less of these is the last below */
            if (way == 1) list[i].dims[0]--;
            write_arrays(ctx, list, way == 0 ? i : -1);
            if (way == 1) list[i].dims[0]++;
            pc_context_clear_message(ctx);
            assert_int_equal(load(&copy, ctx), PC_E_FORMAT);
            assert_non_null(strstr(pc_context_message(ctx), path));
            assert_non_null(strstr(pc_context_message(ctx), "spline"));
        }
    for (int i = 0; i < ARRAYS; i++)
        list[i].dims[0] = 0;
    write_arrays(ctx, list, -1);
    pc_context_clear_message(ctx);
    assert_int_equal(load(&copy, ctx), PC_E_FORMAT);
    free_arrays(ctx, list);
}

/* Changes one number: to another of the same array, to a neighbour, by a bit, or to noise. */
static void damage(raw *r, pc_random *random) {
    size_t count = numbers(r), at = pc_random_next(random) % count, other = pc_random_next(random) % count;
    uint8_t *number = r->data + at * r->size;
    switch (pc_random_next(random) % 4) {
    case 0:
        memcpy(number, r->data + other * r->size, r->size);
        break;
    case 1:
        number[0] ^= 1;
        break;
    case 2:
        number[pc_random_next(random) % r->size] ^= (uint8_t)(1U << pc_random_next(random) % 8);
        break;
    default:
        for (size_t i = 0; i < r->size; i++)
            number[i] = (uint8_t)pc_random_next(random);
    }
}

/* What can be asked of a spline that was accepted. */
static void use(pc_context *ctx, pc_tspline *spline) {
    assert_ok(ctx, pc_tmesh_check(&spline->mesh, ctx));
    for (pc_index f = 0; f < spline->mesh.face_count; f++)
        for (int i = 0; i < 4 && !spline->mesh.face[f].ghost; i++) {
            const double *size = spline->mesh.face[f].size;
            pc_surface_place place = pc_tspline_place(spline, f, 0.3 * size[0], 0.6 * size[1]), beyond;
            (void)pc_tspline_evaluate(spline, place);
            (void)pc_tspline_cross(&beyond, spline, place, i);
        }
    const double point[3] = {1, 2, 3};
    pc_facets facets;
    pc_nearest nearest;
    assert_ok(ctx, pc_facets_make(&facets, ctx, spline, 2, false));
    pc_nearest_all(&nearest, spline, &facets, point, 1);
    pc_facets_free(&facets, ctx);
    pc_closure_stats stats;
    uint8_t *wish;
    assert_ok(ctx, pc_new(&wish, ctx, spline->mesh.face_count));
    wish[spline->mesh.face_count / 2] = PC_HALVE_S | PC_HALVE_T;
    pc_status status = pc_insertion_refine(spline, &stats, ctx, wish);
    assert_true(status == PC_OK || status == PC_E_BUG);
    pc_free(ctx, wish);
}

static void damaged_files_are_refused(void **state) {
    pc_context *ctx = *state;
    enum { TRIES = 150 };
    int accepted = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        const uint64_t seed = 70 + (uint64_t)kind;
        pc_random random = {seed};
        pc_tspline spline = make_spline(ctx, kind, seed), copy;
        raw list[ARRAYS], fresh[ARRAYS];
        save(ctx, &spline);
        read_arrays(ctx, fresh), read_arrays(ctx, list);
        for (int i = 0; i < TRIES; i++) {
            size_t changes = 1 + pc_random_next(&random) % 3;
            for (size_t k = 0; k < changes; k++)
                damage(list + pc_random_next(&random) % ARRAYS, &random);
            write_arrays(ctx, list, -1);
            pc_context_clear_message(ctx);
            pc_status status = load(&copy, ctx);
            if (status == PC_OK) {
                accepted++;
                use(ctx, &copy);
                pc_tspline_free(&copy, ctx);
            } else if (status != PC_E_FORMAT || !strstr(pc_context_message(ctx), path)) {
                fail_msg("seed %llu, try %d: %s (%s)", (unsigned long long)seed, i, pc_status_name(status),
                         pc_context_message(ctx));
            }
            for (int k = 0; k < ARRAYS; k++)
                memcpy(list[k].data, fresh[k].data, numbers(list + k) * list[k].size);
        }
        free_arrays(ctx, list), free_arrays(ctx, fresh);
        pc_tspline_free(&spline, ctx);
    }
    print_message("%d of %d accepted\n", accepted, KINDS * TRIES);
}

/* Whichever allocation fails, both say so and leave nothing behind. */
static void missing_memory_is_survived(void **state) {
    pc_context *ctx = *state;
    pc_tspline spline = make_spline(ctx, PLANE, 80), copy;
    pc_status status = PC_E_NOMEM;
    pc_store *store;
    save(ctx, &spline);
    assert_ok(ctx, pc_store_open(&store, ctx, path));
    size_t before = pc_memory_used(ctx);
    for (size_t n = 1; status == PC_E_NOMEM; n = n < 60 ? n + 1 : n + n / 3) {
        pc_memory_fail_at(ctx, n);
        status = pc_tspline_load(&copy, store, "spline");
        if (status == PC_E_NOMEM) assert_int_equal(pc_memory_used(ctx), before);
    }
    pc_memory_fail_at(ctx, 0);
    assert_int_equal(status, PC_OK);
    pc_tspline_free(&copy, ctx);
    pc_store_close(store);
    pc_tspline_free(&spline, ctx);
}

/* docs/file-format.md has a row for every dataset; skipped without h5py. */
static void all_datasets_are_documented(void **state) {
    pc_context *ctx = *state;
    pc_tspline spline = make_spline(ctx, PLANE, 90);
    save(ctx, &spline);
    pc_tspline_free(&spline, ctx);
    int result = run_python("tests/readers/check_documented.py", path, NULL, NULL);
    if (result == PYTHON_SKIPS) skip();
    assert_int_equal(result, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(splines_come_back, make_context, free_context),
        cmocka_unit_test_setup_teardown(refinement_goes_on, make_context, free_context),
        cmocka_unit_test_setup_teardown(fitting_goes_on, make_context, free_context),
        cmocka_unit_test_setup_teardown(missing_and_short_arrays_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(damaged_files_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(missing_memory_is_survived, make_context, free_context),
        cmocka_unit_test_setup_teardown(all_datasets_are_documented, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
