#include "spline_files.h"
#include "bext.h"
#include "bvh.h"
#include "cage.h"
#include "folder.h"
#include "gismo.h"
#include "iga.h"
#include "iges.h"
#include "memory.h"
#include "skin.h"
#include "step.h"
#include "vtkhdf.h"
#include <stdio.h>

pc_status pc_spline_findings_make(pc_spline_findings *findings, pc_run *run) {
    enum { PER_SIDE = 3 };
    const pc_held_spline *held = &run->product.spline;
    pc_status status = PC_OK;
    *findings = (pc_spline_findings){.held = held};
    pc_continuity_measure(findings->jump, &held->surface, PER_SIDE);
    PC_TRY(pc_tspline_measure(&findings->measure, run->ctx, &held->surface));
    PC_TRY(pc_shell_make(&findings->shell, run->ctx, &held->surface));
    PC_TRY(pc_shell_check(&findings->shell, run->ctx, held->diagonal));
done:
    if (status != PC_OK) pc_spline_findings_free(findings, run->ctx);
    return status;
}

void pc_spline_findings_free(pc_spline_findings *findings, pc_context *ctx) {
    pc_shell_free(&findings->shell, ctx);
}

static void put_jump(pc_json *json, const char *name, const pc_jump *jump, double diagonal) {
    const double degree = 180 / PC_PI;
    pc_json_flat_object(json, name);
    pc_json_integer(json, "samples", jump->sample_count);
    pc_json_number(json, "gap", jump->gap / diagonal);
    pc_json_number(json, "normal_mean_degrees", degree * jump->normal_mean);
    pc_json_number(json, "normal_max_degrees", degree * jump->normal_max);
    pc_json_number(json, "curvature_mean", jump->curvature_mean);
    pc_json_number(json, "curvature_max", jump->curvature_max);
    pc_json_close(json);
}

void pc_spline_findings_put(pc_json *json, const pc_spline_findings *findings) {
    const pc_held_spline *held = findings->held;
    const pc_accuracy *accuracy = &held->stats.accuracy;
    const double part = 1 / held->diagonal;
    pc_json_object(json, "spline");
    pc_json_integer(json, "control_points", held->surface.mesh.vertex_count);
    pc_json_integer(json, "bezier_elements", held->surface.basis.element_count);
    pc_json_integer(json, "t_junctions", held->stats.junctions);
    pc_json_number(json, "tolerance", held->tolerance * part);
    pc_json_flat_object(json, "distance");
    pc_json_number(json, "max", accuracy->max * part);
    pc_json_number(json, "scan_to_spline_max", accuracy->scan_max * part);
    pc_json_number(json, "scan_to_spline_mean", accuracy->scan_mean * part);
    pc_json_number(json, "spline_to_scan_max", accuracy->surface_max * part);
    pc_json_number(json, "spline_to_scan_mean", accuracy->surface_mean * part);
    pc_json_integer(json, "samples", (int64_t)accuracy->samples);
    pc_json_integer(json, "samples_beyond_borders", (int64_t)accuracy->beyond);
    pc_json_close(json);
    pc_json_number(json, "area", findings->measure.area);
    if (findings->measure.closed) pc_json_number(json, "volume", findings->measure.volume);
    pc_json_object(json, "jumps");
    for (int c = 0; c < PC_JOINT_COUNT; c++)
        put_jump(json, pc_joint_name((pc_joint)c), findings->jump + c, held->diagonal);
    pc_json_close(json);
    pc_json_flat_object(json, "shell");
    pc_json_integer(json, "faces", findings->shell.face_count);
    pc_json_integer(json, "edges", findings->shell.edge_count);
    pc_json_integer(json, "border_edges", findings->shell.border_count);
    pc_json_integer(json, "components", findings->shell.component_count);
    pc_json_close(json);
    pc_json_close(json);
}

void pc_spline_findings_certify(pc_certificate *certificate, const pc_held_spline *spline,
                                pc_index most_points) {
    const pc_accuracy *accuracy = &spline->stats.accuracy;
    pc_check *check = pc_certificate_add(certificate, "spline tolerance", accuracy->max, spline->tolerance,
                                         accuracy->max <= spline->tolerance);
    (void)snprintf(check->note, sizeof check->note,
                   "largest distance, %.3g %% of the diagonal, %u control points",
                   100 * accuracy->max / spline->diagonal, spline->surface.mesh.vertex_count);
    if (most_points) {
        check = pc_certificate_add(certificate, "control points", spline->surface.mesh.vertex_count,
                                   most_points, spline->surface.mesh.vertex_count <= most_points);
        (void)snprintf(check->note, sizeof check->note, "at most; fewer quads to start from make fewer");
    }
    check = pc_certificate_add(certificate, "spline basis", spline->facts.worst_sum, 0,
                               spline->facts.worst_sum < 1e-10 && spline->facts.least_pivot > 0);
    (void)snprintf(check->note, sizeof check->note,
                   "largest miss of the sum of the functions; least pivot %.2g", spline->facts.least_pivot);
}

static const struct {
    const char *name, *ending;
} formats[PC_SPLINE_FORMATS] = {
    [PC_SPLINE_IGES] = {"iges", ".igs"},
    [PC_SPLINE_IGA] = {"iga", ".iga"},
    [PC_SPLINE_BEXT] = {"bext", ".bext"},
    [PC_SPLINE_GISMO] = {"gismo", ".xml"},
};

const char *pc_spline_format_name(pc_spline_format format) {
    return formats[format].name;
}

static pc_status write_format(pc_run *run, const pc_spline_findings *findings, pc_spline_format format) {
    const pc_tspline *spline = &findings->held->surface;
    pc_context *ctx = run->ctx;
    char *path;
    pc_status status = pc_folder_join(&path, ctx, run->out, PC_OUT_SURFACE, formats[format].ending);
    if (status != PC_OK) return status;
    switch (format) {
    case PC_SPLINE_IGES:
        status = pc_iges_write(ctx, &findings->shell, findings->held->diagonal, PC_OUT_SURFACE, path, true);
        break;
    case PC_SPLINE_IGA:
        status = pc_iga_write(ctx, spline, path, true);
        break;
    case PC_SPLINE_BEXT:
        status = pc_bext_write(ctx, spline, path, true);
        break;
    case PC_SPLINE_GISMO:
        status = pc_gismo_write(ctx, &findings->shell, path, true);
        break;
    case PC_SPLINE_FORMATS:
        break;
    }
    pc_free(ctx, path);
    return status;
}

pc_status pc_spline_skin_write(pc_run *run) {
    enum { STEPS = 4 };
    const pc_store_options options = {.force = true, .compress = run->options->compress};
    const pc_tspline *spline = &run->product.spline.surface;
    pc_skin skin = {0};
    pc_bvh tree = {0};
    pc_bvh_hit *hits = NULL;
    double *distance = NULL;
    char *path = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_stage_hold(run, PC_STAGE_MESH));
    PC_TRY(pc_skin_make(&skin, run->ctx, spline, STEPS, NULL));
    PC_TRY(pc_bvh_make(&tree, run->ctx, &run->product.mesh.mesh));
    PC_TRY(pc_new(&hits, run->ctx, skin.mesh.vertex_count));
    PC_TRY(pc_new(&distance, run->ctx, skin.mesh.vertex_count));
    pc_bvh_closest_all(hits, &tree, skin.mesh.position, skin.mesh.vertex_count);
    for (pc_index v = 0; v < skin.mesh.vertex_count; v++)
        distance[v] = hits[v].distance;
    PC_TRY(pc_folder_join(&path, run->ctx, run->out, PC_OUT_SURFACE, ".hdf"));
    PC_TRY(pc_vtkhdf_write_surface(run->ctx, path, spline, &skin, distance, &options));
done:
    pc_free(run->ctx, path);
    pc_free(run->ctx, distance);
    pc_free(run->ctx, hits);
    pc_bvh_free(&tree, run->ctx);
    pc_skin_free(&skin, run->ctx);
    return status;
}

static pc_status write_texts(pc_run *run, const pc_spline_findings *findings) {
    char *step = NULL, *cage = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_folder_join(&step, run->ctx, run->out, PC_OUT_SURFACE, ".step"));
    PC_TRY(pc_step_write(run->ctx, &findings->shell, findings->held->diagonal, PC_OUT_SURFACE, step, true));
    PC_TRY(pc_folder_join(&cage, run->ctx, run->out, PC_OUT_CAGE, ""));
    PC_TRY(pc_cage_write(run->ctx, &findings->held->surface, cage, true));
    for (int format = 0; format < PC_SPLINE_FORMATS; format++)
        if (run->options->spline_formats >> format & 1)
            PC_TRY(write_format(run, findings, (pc_spline_format)format));
done:
    pc_free(run->ctx, step);
    pc_free(run->ctx, cage);
    return status;
}

static void *write_apart(void *of) {
    pc_spline_texts *texts = of;
    texts->status = write_texts(texts->run, texts->findings);
    return NULL;
}

void pc_spline_texts_start(pc_spline_texts *texts, pc_run *run, const pc_spline_findings *findings) {
    *texts = (pc_spline_texts){.run = run, .findings = findings};
    texts->apart = pthread_create(&texts->thread, NULL, write_apart, texts) == 0;
    if (!texts->apart) (void)write_apart(texts);
}

pc_status pc_spline_texts_finish(pc_spline_texts *texts) {
    if (texts->run && texts->apart) (void)pthread_join(texts->thread, NULL);
    texts->run = NULL;
    return texts->status;
}
