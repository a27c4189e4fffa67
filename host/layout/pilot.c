#include "pilot.h"
#include "geometry.h"
#include "memory.h"
#include "vec3.h"

enum { EDGES_PER_CELL = 4 };          /* along its side: fewer, and PGP leaves out lines */
enum { LEAST_FACES = 200000 };        /* others are quick */
static const double WORTHWHILE = 2.0; /* times fewer triangles */
enum { SWEEPS = 4 };

/* Of equilateral triangles with sides of these lengths on the same surface. */
static double faces_needed(const pc_mesh *mesh, const double *longest) {
    const double typical = 0.75; /* edges are mostly shorter than they may be */
    double faces = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        const pc_index *t = mesh->triangle + 3 * (size_t)f;
        const double area =
            pc_triangle_area(pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]),
                             pc_vec3_at(mesh->position, t[2]));
        const double side = typical * (longest[t[0]] + longest[t[1]] + longest[t[2]]) / 3;
        faces += area / (sqrt(3) / 4 * side * side);
    }
    return faces;
}

pc_status pc_pilot_make(pc_pilot *pilot, pc_context *ctx, pc_device *device, const pc_mesh *mesh,
                        const pc_adjacency *adjacency, const pc_field *field, const double *scale,
                        double period_length) {
    pc_status status = PC_OK;
    double *longest = NULL;
    *pilot = (pc_pilot){0};
    if (mesh->face_count < LEAST_FACES) return PC_OK;
    PC_TRY(pc_new(&longest, ctx, mesh->vertex_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        longest[v] = period_length / (EDGES_PER_CELL * scale[v]);
    if (WORTHWHILE * faces_needed(mesh, longest) > mesh->face_count) goto done;
    PC_TRY(pc_coarsen(&pilot->coarse, ctx, mesh, adjacency, longest));
    PC_TRY(pc_adjacency_make(&pilot->adjacency, ctx, &pilot->coarse.mesh));
    PC_TRY(pc_field_sample(&pilot->field, ctx, device, &pilot->coarse.mesh, &pilot->adjacency, field,
                           pilot->coarse.source));
done:
    pc_free(ctx, longest);
    if (status != PC_OK) pc_pilot_free(pilot, ctx);
    return status;
}

void pc_pilot_free(pc_pilot *pilot, pc_context *ctx) {
    pc_coarse_free(&pilot->coarse, ctx);
    pc_adjacency_free(&pilot->adjacency, ctx);
    pc_field_free(&pilot->field, ctx);
}

/* Each value becomes the mean of its own and its neighbours'. */
static void even_out(double *out, const double *in, const pc_mesh *mesh, const pc_adjacency *adjacency) {
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < mesh->vertex_count; v++) {
        pc_index h = adjacency->vertex_half[v], first = h;
        double sum = in[v];
        int count = 1;
        out[v] = in[v];
        if (h == PC_NONE) continue;
        do {
            sum += in[pc_head(mesh, h)], count++;
            h = pc_turn_ccw(adjacency, h);
        } while (h != PC_NONE && h != first);
        out[v] = sum / count;
    }
}

pc_status pc_pilot_carry(double *value, pc_context *ctx, const pc_pilot *pilot, const double *coarse,
                         const pc_mesh *mesh, const pc_adjacency *adjacency) {
    pc_status status = PC_OK;
    double *other = NULL;
    PC_TRY(pc_new(&other, ctx, mesh->vertex_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (pilot->coarse.into[v] != PC_NONE) value[v] = coarse[pilot->coarse.into[v]];
    for (int sweep = 0; sweep < SWEEPS; sweep += 2) {
        even_out(other, value, mesh, adjacency);
        even_out(value, other, mesh, adjacency);
    }
done:
    pc_free(ctx, other);
    return status;
}
