/* Stretch and shear of parameterizations that are known: linear maps of a plane, wrapped into periods and
 * turned at random at every vertex. */
#include "distortion.h"
#include "memory.h"
#include "random.h"
#include "synth.h"
#include "testing.h"
#include "vec3.h"

/* S^r with S(s,t) = (t,-s), on whole numbers. */
static void turn(int64_t st[2], int r) {
    for (; r > 0; r--) {
        int64_t s = st[0];
        st[0] = st[1], st[1] = -s;
    }
}

/* (s,t) = A (x,y), each vertex in a frame turned by a random quarter and moved by whole periods. */
static void make_param(pc_param *param, pc_context *ctx, const pc_mesh *mesh, const double a[4],
                       uint64_t seed) {
    *param =
        (pc_param){.vertex_count = mesh->vertex_count, .face_count = mesh->face_count, .period_length = 1};
    int64_t *global;
    int *frame;
    pc_random random = {seed};
    assert_ok(ctx, pc_new(&param->coordinate, ctx, 2 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&param->turn, ctx, 3 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->shift, ctx, 6 * (size_t)mesh->face_count));
    assert_ok(ctx, pc_new(&param->singular, ctx, mesh->face_count));
    assert_ok(ctx, pc_new(&global, ctx, 2 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&frame, ctx, mesh->vertex_count));
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double x = mesh->position[3 * v], y = mesh->position[3 * v + 1];
        int64_t st[2];
        for (int i = 0; i < 2; i++)
            st[i] = global[2 * v + i] = (int64_t)llround((a[2 * i] * x + a[2 * i + 1] * y) * PC_PERIOD);
        frame[v] = (int)(pc_random_next(&random) % 4);
        turn(st, frame[v]);
        for (int i = 0; i < 2; i++)
            param->coordinate[2 * v + i] = (int32_t)(st[i] & (PC_PERIOD - 1));
    }
    for (pc_index h = 0; h < 3 * mesh->face_count; h++) {
        pc_index i = pc_tail(mesh, h), j = pc_head(mesh, h);
        /* The head in the tail's frame and wrapping, less the head's own coordinates turned there. */
        int64_t there[2] = {global[2 * j], global[2 * j + 1]}, here[2] = {global[2 * i], global[2 * i + 1]};
        int64_t own[2] = {param->coordinate[2 * j], param->coordinate[2 * j + 1]};
        param->turn[h] = (uint8_t)((frame[i] - frame[j] + 4) % 4);
        turn(there, frame[i]);
        turn(here, frame[i]);
        turn(own, param->turn[h]);
        for (int k = 0; k < 2; k++) {
            int64_t seen = there[k] - here[k] + param->coordinate[2 * i + k] - own[k];
            assert_int_equal(seen % PC_PERIOD, 0);
            param->shift[2 * h + k] = (int32_t)(seen / PC_PERIOD);
        }
    }
    pc_free(ctx, global);
    pc_free(ctx, frame);
}

static pc_distortion of_linear_map(pc_context *ctx, const double a[4], uint64_t seed) {
    pc_mesh mesh;
    pc_param param;
    pc_distortion d;
    assert_ok(ctx, pc_synth_plane(&mesh, ctx, 5, 4, 37, 23));
    make_param(&param, ctx, &mesh, a, seed);
    for (pc_index f = 0; f < 10; f++) /* not looked at: must not disturb */
        param.singular[f] = PC_DISLOCATION, param.shift[6 * f] += 9;
    assert_ok(ctx, pc_distortion_measure(&d, ctx, &mesh, &param));
    assert_int_equal(d.dislocations, 10);
    assert_int_equal(d.regular_faces, mesh.face_count - 10);
    pc_param_free(&param, ctx);
    pc_mesh_free(&mesh, ctx);
    return d;
}

static void linear_maps(void **state) {
    pc_context *ctx = *state;
    for (uint64_t seed = 0; seed < 8; seed++) {
        const double rigid[4] = {3 * cos(0.3), 3 * sin(0.3), -3 * sin(0.3), 3 * cos(0.3)};
        pc_distortion d = of_linear_map(ctx, rigid, seed);
        assert_true(fabs(d.stretch - 1) < 1e-6 && d.shear < 1e-6 && d.length_error < 1e-6);
        const double squeezed[4] = {2, 0, 0, 1}; /* singular values 1/2 and 1: sqrt((1/4+1)/2) * sqrt(2) */
        d = of_linear_map(ctx, squeezed, seed);
        assert_true(fabs(d.stretch - sqrt(1.25)) < 1e-6 && d.shear < 1e-6 &&
                    fabs(d.length_error - 0.5) < 1e-6);
        assert_true(fabs(d.stretch_core - sqrt(1.25)) < 1e-6);
        const double sheared[4] = {1, -1, 0, 1}; /* dX/ds = (1,0), dX/dt = (1,1) */
        d = of_linear_map(ctx, sheared, seed);
        assert_true(fabs(d.stretch - sqrt(1.5)) < 1e-6 && fabs(d.shear - sqrt(0.5)) < 1e-6);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(linear_maps, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
