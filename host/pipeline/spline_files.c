#include "spline_files.h"
#include "folder.h"
#include "memory.h"
#include "step.h"
#include <stdio.h>

pc_status pc_spline_findings_make(pc_spline_findings *findings, pc_run *run) {
    enum { PER_SIDE = 3 };
    const pc_held_spline *held = &run->product.spline;
    pc_status status = PC_OK;
    *findings = (pc_spline_findings){.held = held};
    pc_continuity_measure(findings->jump, &held->surface, PER_SIDE);
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
    static const char *const joint[PC_JOINT_COUNT] = {"regular", "mixed", "closing", "spoke"};
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
    pc_json_object(json, "jumps");
    for (int c = 0; c < PC_JOINT_COUNT; c++)
        put_jump(json, joint[c], findings->jump + c, held->diagonal);
    pc_json_close(json);
    pc_json_flat_object(json, "shell");
    pc_json_integer(json, "faces", findings->shell.face_count);
    pc_json_integer(json, "edges", findings->shell.edge_count);
    pc_json_integer(json, "border_edges", findings->shell.border_count);
    pc_json_integer(json, "components", findings->shell.component_count);
    pc_json_close(json);
    pc_json_close(json);
}

void pc_spline_findings_certify(pc_certificate *certificate, const pc_held_spline *spline) {
    const pc_accuracy *accuracy = &spline->stats.accuracy;
    pc_check *check = pc_certificate_add(certificate, "spline tolerance", accuracy->max, spline->tolerance,
                                         accuracy->max <= spline->tolerance);
    (void)snprintf(check->note, sizeof check->note,
                   "largest distance, %.3g %% of the diagonal, %u control points",
                   100 * accuracy->max / spline->diagonal, spline->surface.mesh.vertex_count);
    check = pc_certificate_add(certificate, "spline basis", spline->facts.worst_sum, 0,
                               spline->facts.worst_sum < 1e-10 && spline->facts.least_pivot > 0);
    (void)snprintf(check->note, sizeof check->note,
                   "largest miss of the sum of the functions; least pivot %.2g", spline->facts.least_pivot);
}

pc_status pc_spline_files_write(pc_run *run, const pc_spline_findings *findings) {
    char *path = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_folder_join(&path, run->ctx, run->out, PC_OUT_SURFACE, ".step"));
    PC_TRY(pc_step_write(run->ctx, &findings->shell, findings->held->diagonal, PC_OUT_SURFACE, path, true));
done:
    pc_free(run->ctx, path);
    return status;
}
