/* Parts of meshes laid flat: no triangle turns over, holes are filled, and what is no disk is said to be
 * none. */
#include "disk.h"
#include "memory.h"
#include "random.h"
#include "synth.h"
#include "testing.h"
#include <math.h>
#include <string.h>

typedef struct scene {
    pc_mesh mesh;
    pc_adjacency adjacency;
    uint8_t *inside;
} scene;

static void open_scene(scene *s, pc_context *ctx) {
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->mesh));
    assert_ok(ctx, pc_new(&s->inside, ctx, s->mesh.face_count));
}

static void close_scene(scene *s, pc_context *ctx) {
    pc_free(ctx, s->inside);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->mesh, ctx);
}

static pc_vec3 middle_of(const pc_mesh *mesh, pc_index t) {
    pc_vec3 sum = {0, 0, 0};
    for (size_t k = 0; k < 3; k++)
        sum = pc_madd(sum, 1.0 / 3, pc_vec3_at(mesh->position, mesh->triangle[3 * (size_t)t + k]));
    return sum;
}

static void lay_by_length(pc_disk *disk, pc_context *ctx) {
    double *length = NULL, *angle = NULL;
    assert_ok(ctx, pc_new(&length, ctx, 3 * (size_t)disk->mesh.face_count));
    assert_ok(ctx, pc_new(&angle, ctx, disk->loop_count));
    for (pc_index h = 0; h < 3 * disk->mesh.face_count; h++)
        length[h] = pc_distance(pc_vec3_at(disk->mesh.position, pc_tail(&disk->mesh, h)),
                                pc_vec3_at(disk->mesh.position, pc_head(&disk->mesh, h)));
    for (pc_index i = 0; i < disk->loop_count; i++)
        angle[i] = 2 * PC_PI * i / disk->loop_count;
    assert_ok(ctx, pc_disk_lay(disk, ctx, angle, length));
    pc_free(ctx, length);
    pc_free(ctx, angle);
}

static double flat_area(const pc_disk *disk, pc_index t) {
    const pc_index *v = disk->mesh.triangle + 3 * (size_t)t;
    const double *a = disk->mesh.position + 3 * (size_t)v[0], *b = disk->mesh.position + 3 * (size_t)v[1],
                 *c = disk->mesh.position + 3 * (size_t)v[2];
    return ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2;
}

/* A rough landscape with a pit much deeper than it is wide. */
static void nothing_turns_over(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 1; seed <= 10; seed++) {
        pc_random random = {seed};
        scene s = {0};
        pc_disk disk;
        double sum = 0;
        assert_ok(ctx, pc_synth_plane(&s.mesh, ctx, 1, 1, 24, 24));
        for (pc_index v = 0; v < s.mesh.vertex_count; v++) {
            double *p = s.mesh.position + 3 * (size_t)v;
            const double away = hypot(p[0] - 0.5, p[1] - 0.5);
            p[2] = 0.04 * pc_random_uniform(&random) - (away < 0.2 ? 2 * (1 - away / 0.2) : 0);
        }
        open_scene(&s, ctx);
        for (pc_index t = 0; t < s.mesh.face_count; t++) {
            const pc_vec3 m = middle_of(&s.mesh, t);
            s.inside[t] = hypot(m.x - 0.5, m.y - 0.5) < 0.3 + 0.15 * pc_random_uniform(&random);
        }
        assert_ok(ctx, pc_disk_make(&disk, ctx, &s.mesh, &s.adjacency, s.inside));
        assert_true(disk.loop_count > 0);
        lay_by_length(&disk, ctx);
        for (pc_index t = 0; t < disk.mesh.face_count; t++) {
            if (!(flat_area(&disk, t) > 0))
                fail_msg("seed %d: triangle %u has area %g", (int)seed, t, flat_area(&disk, t));
            sum += flat_area(&disk, t);
            assert_int_equal(pc_disk_find(&disk, disk.triangle[t]), t);
            assert_true(s.inside[disk.triangle[t]]);
        }
        const double polygon = 0.5 * disk.loop_count * sin(2 * PC_PI / disk.loop_count);
        assert_true(fabs(sum - polygon) < 1e-9);
        pc_disk_free(&disk, ctx);
        close_scene(&s, ctx);
    }
}

/* Isolated triangles missing inside, isolated ones outside, and a corner that touches the rim. */
static void holes_are_filled(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_disk disk;
    assert_ok(ctx, pc_synth_plane(&s.mesh, ctx, 1, 1, 30, 30));
    open_scene(&s, ctx);
    pc_index within = 0;
    for (pc_index t = 0; t < s.mesh.face_count; t++) {
        const pc_vec3 m = middle_of(&s.mesh, t);
        s.inside[t] = fabs(m.x - 0.5) < 0.3 && fabs(m.y - 0.5) < 0.3;
        within += s.inside[t];
    }
    for (pc_index t = 0; t < s.mesh.face_count; t++) {
        const pc_vec3 m = middle_of(&s.mesh, t);
        if (hypot(m.x - 0.45, m.y - 0.5) < 0.08) s.inside[t] = 0;
        if (hypot(m.x - 0.9, m.y - 0.9) < 0.05) s.inside[t] = 1;
    }
    assert_ok(ctx, pc_disk_make(&disk, ctx, &s.mesh, &s.adjacency, s.inside));
    assert_int_equal(disk.mesh.face_count, within);
    assert_true(disk.loop_count > 0);
    assert_int_equal(pc_disk_find(&disk, s.mesh.face_count - 1), PC_NONE);
    pc_disk_free(&disk, ctx);
    close_scene(&s, ctx);
}

static void what_is_no_disk(void **state) {
    pc_context *ctx = *state;
    scene s = {0};
    pc_disk disk;
    assert_ok(ctx, pc_synth_torus(&s.mesh, ctx, 2, 1, 48, 24));
    open_scene(&s, ctx);
    for (int shape = 0; shape < 3; shape++) { /* nothing, all, a tube */
        for (pc_index t = 0; t < s.mesh.face_count; t++) {
            const pc_vec3 m = middle_of(&s.mesh, t);
            s.inside[t] = shape == 1 || (shape == 2 && m.x > 0 && fabs(m.y) < 0.5);
        }
        assert_ok(ctx, pc_disk_make(&disk, ctx, &s.mesh, &s.adjacency, s.inside));
        assert_int_equal(disk.loop_count, 0);
        pc_disk_free(&disk, ctx);
    }
    close_scene(&s, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nothing_turns_over, make_context, free_context),
        cmocka_unit_test_setup_teardown(holes_are_filled, make_context, free_context),
        cmocka_unit_test_setup_teardown(what_is_no_disk, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
