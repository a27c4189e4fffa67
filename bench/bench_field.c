/* Singularities, alignment and time of the field stage: bench_field [-d DEVICE] [-s RHO] [-p FOLDER] SCAN...
 * A line per scan: triangles, singular faces, mean angle to the curvature's directions (weighted by their
 * weight), and to sharp edges (dihedral over 35 degrees), seconds of curvature and of field; then seconds per
 * kernel. -p also writes a picture of each field. scripts/peer_singularities.py prints what other programs
 * put on the same scans. */
#include "adjacency.h"
#include "clock.h"
#include "field.h"
#include "geometry.h"
#include "memory.h"
#include "png_file.h"
#include "repair.h"
#include "scan.h"
#include "scene.h"
#include "singularity.h"
#include "vec3.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct setup {
    pc_device *device;
    const char *pictures;
    pc_field_options field;
} setup;

/* Radians between a direction of the cross at v and a vector. */
static double cross_angle(const pc_field *field, pc_index v, pc_vec3 along) {
    pc_vec3 k = pc_vec3_at(field->direction, v), n = pc_vec3_at(field->normal, v);
    double a = fmod(fabs(atan2(pc_dot(along, pc_cross(n, k)), pc_dot(along, k))), PC_PI / 2);
    return a > PC_PI / 4 ? PC_PI / 2 - a : a;
}

static double off_curvature(const pc_field *field, const pc_curvature *curvature) {
    double sum = 0, weights = 0;
    for (pc_index v = 0; v < field->vertex_count; v++) {
        sum += curvature->weight[v] * cross_angle(field, v, pc_vec3_at(curvature->direction, v));
        weights += curvature->weight[v];
    }
    return weights > 0 ? sum / weights * 180 / PC_PI : 0;
}

static pc_vec3 corner(const pc_mesh *mesh, pc_index h) {
    return pc_vec3_at(mesh->position, mesh->triangle[h]);
}

static pc_vec3 normal_of(const pc_mesh *mesh, pc_index h) {
    return pc_triangle_normal(corner(mesh, h), corner(mesh, pc_next(h)), corner(mesh, pc_prev(h)));
}

static double off_sharp_edges(const pc_field *field, const pc_mesh *mesh, const pc_adjacency *a) {
    double sum = 0, lengths = 0;
    for (pc_index e = 0; e < a->edge_count; e++) {
        pc_index h = a->edge_half[e], twin = a->twin[h];
        if (twin == PC_NONE || pc_dot(normal_of(mesh, h), normal_of(mesh, twin)) > cos(35 * PC_PI / 180))
            continue;
        pc_vec3 along = pc_sub(corner(mesh, pc_next(h)), corner(mesh, h));
        double length = pc_norm(along);
        sum += length *
               (cross_angle(field, pc_tail(mesh, h), along) + cross_angle(field, pc_head(mesh, h), along));
        lengths += 2 * length;
    }
    return lengths > 0 ? sum / lengths * 180 / PC_PI : 0;
}

static pc_status draw(pc_context *ctx, const char *path, const pc_mesh *mesh, const pc_field *field) {
    pc_status status = PC_OK;
    pc_picture picture = {0};
    pc_picture_options options = PC_PICTURE_DEFAULTS;
    PC_TRY(pc_picture_make(&picture, ctx, mesh->position, mesh->vertex_count, &options));
    PC_TRY(pc_scene_scan(&picture, ctx, mesh));
    PC_TRY(pc_scene_field(&picture, ctx, mesh, field));
    PC_TRY(pc_png_save(ctx, path, &picture));
done:
    pc_picture_free(&picture, ctx);
    return status;
}

static pc_status measure(pc_context *ctx, const setup *s, const char *name, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    pc_adjacency adjacency = {0};
    pc_curvature curvature = {0};
    pc_field field = {0};
    pc_curvature_options options = PC_CURVATURE_DEFAULTS;
    char path[4096];
    PC_TRY(pc_adjacency_make(&adjacency, ctx, mesh));
    double begin = pc_clock_wall();
    PC_TRY(pc_curvature_make(&curvature, ctx, s->device, mesh, &adjacency, &options));
    double middle = pc_clock_wall();
    PC_TRY(pc_field_make(&field, ctx, s->device, mesh, &adjacency, &curvature, &s->field));
    double end = pc_clock_wall();
    printf(
        "%-24s %8u triangles %6u singular, %5.1f deg to curvature, %5.1f to sharp edges, %6.2f + %6.2f s\n",
        name, mesh->face_count, pc_singularity_count(&field), off_curvature(&field, &curvature),
        off_sharp_edges(&field, mesh, &adjacency), middle - begin, end - middle);
    (void)fflush(stdout);
    if (s->pictures) {
        (void)snprintf(path, sizeof path, "%s/%s.png", s->pictures, name);
        PC_TRY(draw(ctx, path, mesh, &field));
    }
done:
    pc_field_free(&field, ctx);
    pc_curvature_free(&curvature, ctx);
    pc_adjacency_free(&adjacency, ctx);
    return status;
}

static pc_status bench_scan(pc_context *ctx, const setup *s, const char *path) {
    pc_status status = PC_OK;
    pc_mesh scan = {0}, mesh = {0};
    pc_scan_info info;
    pc_repair_options options = PC_REPAIR_DEFAULTS;
    pc_repair_report report = {0};
    const char *name = strrchr(path, '/');
    PC_TRY(pc_scan_read(&scan, &info, ctx, path));
    PC_TRY(pc_repair(&mesh, &report, ctx, &scan, &options));
    PC_TRY(measure(ctx, s, name ? name + 1 : path, &mesh));
done:
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&scan, ctx);
    pc_mesh_free(&mesh, ctx);
    return status;
}

static void print_kernels(pc_context *ctx, pc_device *device) {
    const pc_kernel_stats *table;
    size_t count;
    if (pc_device_kernel_stats(&table, &count, ctx, device) != PC_OK) return;
    for (size_t k = 0; k < count; k++)
        printf("  %-24s %6llu launches %9.4f s %7.1f GB/s\n", table[k].name,
               (unsigned long long)table[k].count, table[k].seconds,
               table[k].seconds > 0 ? table[k].bytes / table[k].seconds * 1e-9 : 0);
}

int main(int argc, char **argv) {
    const pc_field_options defaults = PC_FIELD_DEFAULTS;
    setup s = {.field = defaults};
    const char *device = "host";
    pc_context *ctx = pc_context_make();
    int option, failed = 0;
    if (!ctx) return 7;
    while ((option = getopt(argc, argv, "d:s:p:")) != -1) {
        if (option == 'd') device = optarg;
        if (option == 's') s.field.smoothness = strtod(optarg, NULL);
        if (option == 'p') s.pictures = optarg;
        if (option == '?') return 2;
    }
    if (pc_device_open(&s.device, ctx, device) != PC_OK) {
        (void)fprintf(stderr, "%s\n", pc_context_message(ctx));
        return 6;
    }
    for (int k = optind; k < argc; k++)
        if (bench_scan(ctx, &s, argv[k]) != PC_OK) {
            (void)fprintf(stderr, "%s: %s\n", argv[k], pc_context_message(ctx));
            pc_context_clear_message(ctx);
            failed = 1;
        }
    print_kernels(ctx, s.device);
    pc_device_close(s.device, ctx);
    pc_context_free(ctx);
    return failed;
}
