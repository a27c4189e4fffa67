/* What the tests of parameterization and layout share: a shape with its adjacency, field and longest edge. */
#ifndef PC_PARAM_TESTING_H
#define PC_PARAM_TESTING_H

#include "field.h"
#include "param.h"
#include "random.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_wear.h"
#include "testing.h"
#include "topology.h"
#include "vec3.h"

typedef struct shape {
    pc_mesh mesh;
    pc_adjacency adjacency;
    pc_field field;
    double longest_edge, mean_edge;
} shape;

static inline pc_device *open_host(pc_context *ctx) {
    pc_device *device = NULL;
    assert_ok(ctx, pc_device_open(&device, ctx, "host"));
    return device;
}

/* Adjacency and edge lengths of s->mesh, which is there. */
static inline void measure_shape(shape *s, pc_context *ctx) {
    double sum = 0;
    assert_ok(ctx, pc_adjacency_make(&s->adjacency, ctx, &s->mesh));
    s->longest_edge = 0;
    for (pc_index e = 0; e < s->adjacency.edge_count; e++) {
        pc_index h = s->adjacency.edge_half[e];
        double length = pc_distance(pc_vec3_at(s->mesh.position, pc_tail(&s->mesh, h)),
                                    pc_vec3_at(s->mesh.position, pc_head(&s->mesh, h)));
        s->longest_edge = fmax(s->longest_edge, length);
        sum += length;
    }
    s->mean_edge = sum / s->adjacency.edge_count;
}

/* Everything but the mesh, the field by curvature. */
static inline void finish_shape(shape *s, pc_context *ctx, pc_device *device) {
    pc_curvature curvature;
    const pc_curvature_options curvature_options = PC_CURVATURE_DEFAULTS;
    const pc_field_options field_options = PC_FIELD_DEFAULTS;
    measure_shape(s, ctx);
    assert_ok(ctx, pc_curvature_make(&curvature, ctx, device, &s->mesh, &s->adjacency, &curvature_options));
    assert_ok(ctx,
              pc_field_make(&s->field, ctx, device, &s->mesh, &s->adjacency, &curvature, &field_options));
    pc_curvature_free(&curvature, ctx);
}

static inline void free_shape(shape *s, pc_context *ctx) {
    pc_field_free(&s->field, ctx);
    pc_adjacency_free(&s->adjacency, ctx);
    pc_mesh_free(&s->mesh, ctx);
}

enum { SHAPE_KINDS = 10 };

/* Small shapes of every kind: sphere, tori, cylinder, holed plane, cube, blobs of genus 0 to 3, two
 * components. */
static inline void make_mesh(pc_mesh *mesh, pc_context *ctx, int kind, uint64_t seed) {
    pc_mesh other;
    switch (kind) {
    case 0:
        assert_ok(ctx, pc_synth_sphere(mesh, ctx, 9));
        break;
    case 1:
        assert_ok(ctx, pc_synth_torus(mesh, ctx, 2, 0.8, 40, 20));
        break;
    case 2:
        assert_ok(ctx, pc_synth_cylinder(mesh, ctx, 3, 24, 12));
        break;
    case 3:
        assert_ok(ctx, pc_synth_plane(mesh, ctx, 3, 2, 30, 20));
        assert_ok(ctx, pc_synth_holes(mesh, ctx, 3, 14, seed));
        break;
    case 4:
        assert_ok(ctx, pc_synth_cube(mesh, ctx, 6));
        break;
    case 5:
    case 6:
    case 7:
    case 8:
        assert_ok(ctx, pc_synth_blob(mesh, ctx, (pc_index)kind - 5, 6));
        break;
    default:
        assert_ok(ctx, pc_synth_torus(mesh, ctx, 1, 0.4, 24, 12));
        assert_ok(ctx, pc_synth_sphere(&other, ctx, 3));
        for (size_t i = 0; i < 3 * (size_t)other.vertex_count; i++)
            other.position[i] *= 0.1;
        assert_ok(ctx, pc_synth_append(mesh, ctx, &other, (pc_vec3){3, 0, 0}));
        pc_mesh_free(&other, ctx);
        break;
    }
    assert_ok(ctx, pc_synth_noise(mesh, ctx, 0.1, seed));
    assert_ok(ctx, pc_synth_shuffle(mesh, ctx, seed));
}

#endif
