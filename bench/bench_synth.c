/* Writes a synthetic scan, or a scan made larger or worse, as binary PLY.
 * bench_synth KIND|SCAN [-o FILE.ply] [options], see usage below. */
#include "clock.h"
#include "memory.h"
#include "polyfile.h"
#include "repair.h"
#include "scan.h"
#include "synth.h"
#include "synth_blob.h"
#include "synth_wear.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "bench_synth KIND|SCAN [options] -o FILE.ply\n"
    "kinds: sphere torus cylinder plane cube vase blob soup; what has a dot or a slash is a file\n"
    "  --faces N       about so many triangles, before --subdivide (default 100000)\n"
    "  --genus G       of a blob (default 2)\n"
    "  --copies N      that many components in a row\n"
    "  --subdivide N   every face into four, N times, on curved cubics\n"
    "  --needles F     splits a fraction F of the edges close to an end\n"
    "  --noise A       white noise along the normal, deviation A mean edges\n"
    "  --ripple A      noise that is smooth over --wavelength W mean edges (default 8)\n"
    "  --holes N       ragged holes of --hole-faces N (default 60) faces\n"
    "  --shuffle       random order of vertices and faces\n"
    "  --unweld        every face with vertices of its own\n"
    "  --seed N        other noise, holes, order\n"
    "The same arguments give the same bytes.\n";

typedef struct wishes {
    const char *kind, *path;
    double faces, genus, copies, subdivide, needles, noise, ripple, wavelength, holes, hole_faces, seed;
    bool shuffle, unweld;
} wishes;

typedef struct number_option {
    const char *name;
    double *value;
} number_option;

static bool read_number(const number_option *options, size_t count, const char *name, const char *text) {
    for (size_t i = 0; i < count; i++) {
        if (strcmp(options[i].name, name) != 0) continue;
        char *end = NULL;
        *options[i].value = text ? strtod(text, &end) : -1;
        return end && end != text && *end == 0 && *options[i].value >= 0 && *options[i].value < 4e9;
    }
    return false;
}

static bool read_wishes(wishes *w, int argc, char **argv) {
    const number_option options[] = {
        {"--faces", &w->faces},     {"--genus", &w->genus},         {"--copies", &w->copies},
        {"--noise", &w->noise},     {"--ripple", &w->ripple},       {"--wavelength", &w->wavelength},
        {"--holes", &w->holes},     {"--seed", &w->seed},           {"--hole-faces", &w->hole_faces},
        {"--needles", &w->needles}, {"--subdivide", &w->subdivide},
    };
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--shuffle") == 0) {
            w->shuffle = true;
        } else if (strcmp(argv[i], "--unweld") == 0) {
            w->unweld = true;
        } else if (strcmp(argv[i], "-o") == 0 && i + 1 < argc) {
            w->path = argv[++i];
        } else if (argv[i][0] != '-' && !w->kind) {
            w->kind = argv[i];
        } else {
            const char *text = i + 1 < argc ? argv[i + 1] : NULL;
            if (!read_number(options, sizeof options / sizeof options[0], argv[i], text)) return false;
            i++;
        }
    }
    return w->kind != NULL;
}

static pc_index steps_for(double faces, double faces_per_step2) {
    double steps = sqrt(faces / faces_per_step2);
    return steps > 3 ? (pc_index)(steps + 0.5) : 3;
}

static pc_status make_shape(pc_mesh *mesh, pc_context *ctx, const wishes *w) {
    double faces = w->faces, rings = w->genus > 1 ? w->genus : 1;
    pc_index genus = (pc_index)w->genus, n = steps_for(faces, 2);
    if (strcmp(w->kind, "sphere") == 0) return pc_synth_sphere(mesh, ctx, steps_for(faces, 8));
    if (strcmp(w->kind, "torus") == 0) return pc_synth_torus(mesh, ctx, 2, 1, n + n / 2, n - n / 3);
    if (strcmp(w->kind, "cylinder") == 0) return pc_synth_cylinder(mesh, ctx, 4, n + n / 4, n - n / 5);
    if (strcmp(w->kind, "plane") == 0) return pc_synth_plane(mesh, ctx, 1, 1, n, n);
    if (strcmp(w->kind, "cube") == 0) return pc_synth_cube(mesh, ctx, steps_for(faces, 12));
    if (strcmp(w->kind, "vase") == 0) return pc_synth_vase(mesh, ctx, n - n / 4, n + n / 3);
    if (strcmp(w->kind, "blob") == 0) {
        pc_index steps = steps_for(faces, genus ? 112 * rings + 28 : 112);
        return pc_synth_blob(mesh, ctx, genus, steps < 6 ? 6 : steps);
    }
    if (strcmp(w->kind, "soup") == 0)
        return pc_synth_soup(mesh, ctx, (pc_index)(faces / 2) + 3, (pc_index)faces, (uint64_t)w->seed);
    return pc_fail(ctx, PC_E_USAGE, "no kind \"%s\"", w->kind);
}

static bool is_file(const char *kind) {
    return strpbrk(kind, "./") != NULL;
}

static pc_status read_shape(pc_mesh *mesh, pc_context *ctx, const char *path) {
    const pc_repair_options options = PC_REPAIR_DEFAULTS;
    pc_scan_info info;
    pc_mesh raw = {0};
    pc_repair_report report = {0};
    pc_status status = pc_scan_read(&raw, &info, ctx, path);
    if (status == PC_OK) status = pc_repair(mesh, &report, ctx, &raw, &options);
    pc_repair_report_free(&report, ctx);
    pc_mesh_free(&raw, ctx);
    return status;
}

static pc_status add_copies(pc_mesh *mesh, pc_context *ctx, const wishes *w) {
    pc_mesh one = {0};
    pc_status status = PC_OK;
    double width = 0;
    PC_TRY(pc_mesh_copy(&one, ctx, mesh));
    for (size_t v = 0; v < one.vertex_count; v++)
        width = fmax(width, fabs(one.position[3 * v + 1]));
    for (int i = 1; i < w->copies; i++)
        PC_TRY(pc_synth_append(mesh, ctx, &one, (pc_vec3){0, 2.5 * width * i, 0}));
done:
    pc_mesh_free(&one, ctx);
    return status;
}

static pc_status wear_down(pc_mesh *mesh, pc_context *ctx, const wishes *w) {
    pc_status status = PC_OK;
    uint64_t seed = (uint64_t)w->seed * 16;
    if (w->copies > 1) PC_TRY(add_copies(mesh, ctx, w));
    for (int i = 0; i < w->subdivide; i++)
        PC_TRY(pc_synth_subdivide(mesh, ctx, true));
    if (w->needles > 0) PC_TRY(pc_synth_needles(mesh, ctx, w->needles, seed + 1));
    if (w->ripple > 0) PC_TRY(pc_synth_ripple(mesh, ctx, w->ripple, w->wavelength, seed + 2));
    if (w->noise > 0) PC_TRY(pc_synth_noise(mesh, ctx, w->noise, seed + 3));
    if (w->holes > 0)
        PC_TRY(pc_synth_holes(mesh, ctx, (pc_index)w->holes, (pc_index)w->hole_faces, seed + 4));
    if (w->shuffle) PC_TRY(pc_synth_shuffle(mesh, ctx, seed + 5));
    if (w->unweld) PC_TRY(pc_synth_unweld(mesh, ctx));
done:
    return status;
}

int main(int argc, char **argv) {
    wishes w = {.faces = 1e5, .genus = 2, .copies = 1, .wavelength = 8, .hole_faces = 60};
    if (!read_wishes(&w, argc, argv)) {
        (void)fputs(usage, stderr);
        return pc_status_exit_code(PC_E_USAGE);
    }
    pc_context *ctx = pc_context_make();
    if (!ctx) return pc_status_exit_code(PC_E_NOMEM);
    pc_status status = PC_OK;
    pc_mesh mesh = {0};
    double start = pc_clock_wall(), made;
    PC_TRY(is_file(w.kind) ? read_shape(&mesh, ctx, w.kind) : make_shape(&mesh, ctx, &w));
    PC_TRY(wear_down(&mesh, ctx, &w));
    made = pc_clock_wall();
    if (w.path) PC_TRY(pc_polyfile_write_mesh_ply(ctx, &mesh, w.path, true));
    printf("{\"kind\": \"%s\", \"vertices\": %u, \"faces\": %u, \"make_s\": %.3f, \"write_s\": %.3f}\n",
           w.kind, mesh.vertex_count, mesh.face_count, made - start, pc_clock_wall() - made);
done:
    if (status != PC_OK) (void)fprintf(stderr, "bench_synth: %s\n", pc_context_message(ctx));
    pc_mesh_free(&mesh, ctx);
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
