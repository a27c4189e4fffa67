/* Time per picture, and the pictures to look at: bench_render FOLDER [STEPS] or bench_render FOLDER SCAN...
 * A sphere of 8*STEPS^2 triangles (600: 2.9 M) with crosses, and a torus of quads; or each scan, shaded. */
#include "clock.h"
#include "memory.h"
#include "png_file.h"
#include "polymesh.h"
#include "scan.h"
#include "scene.h"
#include "surface.h"
#include "synth.h"
#include "vec3.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static pc_status sphere_field(pc_field *field, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status;
    *field = (pc_field){.symmetry = 4, .vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    PC_TRY(pc_new(&field->normal, ctx, 3 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&field->direction, ctx, 3 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&field->index, ctx, mesh->face_count));
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        pc_vec3 n = pc_unit(pc_vec3_at(mesh->position, i)), up = {0, 1, 0};
        pc_vec3_put(field->normal, i, n);
        pc_vec3_put(field->direction, i, pc_unit(pc_cross(up, n)));
    }
    field->index[0] = 1, field->index[mesh->face_count / 3] = -1, field->index[mesh->face_count / 7] = 2;
done:
    return status;
}

/* The torus' grid as quads, with a few faces merged or cut so that every colour shows. */
static pc_status torus_quads(pc_polymesh *quads, pc_context *ctx, pc_index around, pc_index across) {
    pc_status status;
    PC_TRY(pc_polymesh_make(quads, ctx, around * across, around * across, 4 * (size_t)around * across));
    for (pc_index j = 0; j < across; j++)
        for (pc_index i = 0; i < around; i++) {
            pc_index f = j * around + i, i1 = (i + 1) % around, j1 = (j + 1) % across;
            double u = 2 * PC_PI * i / around, v = 2 * PC_PI * j / across, r = 2 + 0.8 * cos(v);
            pc_vec3_put(quads->position, f, (pc_vec3){r * cos(u), r * sin(u), 0.8 * sin(v)});
            const pc_index corner[4] = {f, j * around + i1, j1 * around + i1, j1 * around + i};
            for (int k = 0; k < 4; k++)
                quads->corner[4 * f + (pc_index)k] = corner[k];
            quads->start[f + 1] = 4 * (f + 1);
        }
done:
    return status;
}

/* Periods around and across the torus as a parameterization: no singularities. */
static pc_status torus_param(pc_param *param, pc_context *ctx, const pc_mesh *mesh, pc_index around,
                             pc_index across) {
    pc_status status;
    int64_t *whole = NULL; /* per vertex: s and t before they are cut to one period */
    const int64_t round = 30LL * PC_PERIOD, tube = 12LL * PC_PERIOD;
    *param = (pc_param){.vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    param->period_length = 2 * PC_PI * 2 / 30;
    PC_TRY(pc_new(&whole, ctx, 2 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&param->coordinate, ctx, 2 * (size_t)mesh->vertex_count));
    PC_TRY(pc_new(&param->turn, ctx, 3 * (size_t)mesh->face_count));
    PC_TRY(pc_new(&param->shift, ctx, 6 * (size_t)mesh->face_count));
    PC_TRY(pc_new(&param->singular, ctx, mesh->face_count));
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        whole[2 * v] = (int64_t)(v % around) * round / around | 1;
        whole[2 * v + 1] = (int64_t)(v / around) * tube / across | 1;
        for (int c = 0; c < 2; c++)
            param->coordinate[2 * v + c] = (int32_t)(whole[2 * v + c] % PC_PERIOD);
    }
    for (size_t h = 0; h < 3 * (size_t)mesh->face_count; h++)
        for (int c = 0; c < 2; c++) {
            size_t i = 2 * (size_t)pc_tail(mesh, (pc_index)h) + c,
                   j = 2 * (size_t)pc_head(mesh, (pc_index)h) + c;
            int64_t step = whole[j] - whole[i], full = c ? tube : round;
            step += step > full / 2 ? -full : step < -full / 2 ? full : 0;
            param->shift[2 * h + c] =
                (int32_t)((step + param->coordinate[i] - param->coordinate[j]) / PC_PERIOD);
        }
done:
    pc_free(ctx, whole);
    return status;
}

static pc_status save(pc_context *ctx, pc_picture *picture, const char *folder, const char *name,
                      double start, double cpu) {
    char path[1024];
    double drawn = pc_clock_wall();
    cpu = pc_clock_cpu() - cpu;
    (void)snprintf(path, sizeof(path), "%s/%s.png", folder, name);
    pc_status status = pc_png_save(ctx, path, picture);
    pc_picture_free(picture, ctx);
    (void)printf("%-20s drawn %.3f s (%.3f s of processor time), written %.3f s\n", name, drawn - start, cpu,
                 pc_clock_wall() - drawn);
    return status;
}

/* Iso-lines and a map of numbers on a torus. */
static pc_status render_torus(pc_context *ctx, const char *folder) {
    pc_status status;
    pc_mesh mesh = {0};
    pc_param param = {0};
    pc_picture picture = {0};
    double *value = NULL;
    pc_picture_options options = PC_PICTURE_DEFAULTS;
    PC_TRY(pc_synth_torus(&mesh, ctx, 2, 0.8, 300, 120));
    PC_TRY(torus_param(&param, ctx, &mesh, 300, 120));
    double start = pc_clock_wall(), cpu = pc_clock_cpu();
    options.view = PC_VIEW_ISO;
    PC_TRY(pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
    PC_TRY(pc_scene_param(&picture, ctx, &mesh, &param));
    PC_TRY(save(ctx, &picture, folder, "isolines", start, cpu));
    start = pc_clock_wall(), cpu = pc_clock_cpu();
    options.view = PC_VIEW_PAIR, options.legend = 1;
    PC_TRY(pc_new(&value, ctx, mesh.vertex_count));
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        double x = mesh.position[3 * v], y = mesh.position[3 * v + 1], r = sqrt(x * x + y * y);
        value[v] = (r - 2) / 0.64 / r; /* Gaussian curvature */
    }
    PC_TRY(pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
    PC_TRY(pc_scene_values(&picture, ctx, &mesh, value, &pc_colormap_diverging, 0, 0, "Gaussian curvature"));
    PC_TRY(pc_scene_caption(&picture, ctx,
                            "ABCDEFGHIJKLMNOPQRSTUVWXYZ abcdefghijklmnopqrstuvwxyz 0123456789 "
                            "!\"#%&'()*+,-./:;<=>?[\\]^_{|}~"));
    PC_TRY(save(ctx, &picture, folder, "values", start, cpu));
done:
    pc_free(ctx, value);
    pc_picture_free(&picture, ctx);
    pc_param_free(&param, ctx);
    pc_mesh_free(&mesh, ctx);
    return status;
}

static pc_status render(pc_context *ctx, const char *folder, pc_index steps) {
    pc_status status;
    pc_mesh mesh = {0};
    pc_field field = {0};
    pc_polymesh quads = {0};
    pc_picture picture = {0};
    pc_picture_options options = PC_PICTURE_DEFAULTS;
    PC_TRY(pc_synth_sphere(&mesh, ctx, steps));
    PC_TRY(sphere_field(&field, ctx, &mesh));
    for (int crosses = 0; crosses < 2; crosses++) {
        double start = pc_clock_wall(), cpu = pc_clock_cpu();
        PC_TRY(pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
        PC_TRY(pc_scene_scan(&picture, ctx, &mesh));
        if (crosses) PC_TRY(pc_scene_field(&picture, ctx, &mesh, &field));
        PC_TRY(save(ctx, &picture, folder, crosses ? "field" : "scan", start, cpu));
    }
    PC_TRY(torus_quads(&quads, ctx, 60, 24));
    double start = pc_clock_wall(), cpu = pc_clock_cpu();
    PC_TRY(pc_picture_make(&picture, ctx, quads.position, quads.vertex_count, &options));
    PC_TRY(pc_scene_quads(&picture, ctx, &quads));
    PC_TRY(save(ctx, &picture, folder, "quads", start, cpu));
    PC_TRY(render_torus(ctx, folder));
done:
    pc_picture_free(&picture, ctx);
    pc_polymesh_free(&quads, ctx);
    pc_field_free(&field, ctx);
    pc_mesh_free(&mesh, ctx);
    return status;
}

static pc_status render_scan(pc_context *ctx, const char *folder, const char *path) {
    pc_status status;
    pc_mesh mesh = {0};
    pc_scan_info info;
    pc_picture picture = {0};
    pc_picture_options options = PC_PICTURE_DEFAULTS;
    const char *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    PC_TRY(pc_scan_read(&mesh, &info, ctx, path));
    double start = pc_clock_wall(), cpu = pc_clock_cpu();
    PC_TRY(pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
    PC_TRY(pc_scene_scan(&picture, ctx, &mesh));
    PC_TRY(pc_scene_caption(&picture, ctx, name));
    PC_TRY(save(ctx, &picture, folder, name, start, cpu));
done:
    pc_picture_free(&picture, ctx);
    pc_mesh_free(&mesh, ctx);
    return status;
}

int main(int argc, char **argv) {
    if (argc < 2) {
        (void)fprintf(stderr, "usage: bench_render FOLDER [STEPS | SCAN...]\n");
        return 2;
    }
    pc_context *ctx = pc_context_make();
    if (!ctx) return 7;
    pc_status status = PC_OK;
    unsigned long steps = argc > 2 ? strtoul(argv[2], NULL, 10) : 600;
    if (steps > 0) status = render(ctx, argv[1], (pc_index)steps);
    for (int i = 2; i < argc && steps == 0 && status == PC_OK; i++)
        status = render_scan(ctx, argv[1], argv[i]);
    if (status != PC_OK) (void)fprintf(stderr, "%s\n", pc_context_message(ctx));
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
