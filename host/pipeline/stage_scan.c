/* Scan: reads the file and makes its triangles an oriented 2-manifold. */
#include "memory.h"
#include "ragged.h"
#include "repair_facts.h"
#include "stage.h"
#include <stdio.h>
#include <string.h>

static void put_options(pc_json *json, const pc_convert_options *options) {
    pc_json_boolean(json, "strict", options->strict);
    pc_json_integer(json, "min_component", options->min_component);
    pc_json_boolean(json, "keep_ragged", options->keep_ragged);
}

static void note(pc_run *run, const pc_repair_report *report) {
    pc_stage_record *record = &run->record[PC_STAGE_SCAN];
    char line[512];
    pc_facts_repair_line(line, sizeof line, report);
    if (line[0]) pc_log(run->ctx, PC_LOG_WARNING, "%s: %s", run->scan_path, line);
    (void)snprintf(record->note, sizeof record->note, "%u triangles%s", report->face_count,
                   report->changed ? ", repaired" : "");
}

/* Repair knows no files; the user may have many. */
static void name_file(pc_run *run) {
    char message[1024];
    (void)snprintf(message, sizeof message, "%s", pc_context_message(run->ctx));
    pc_context_clear_message(run->ctx);
    (void)pc_fail(run->ctx, PC_E_MESH, "%s: %s", run->scan_path, message);
}

/* Faces that are added come from no triangle of the file. */
static pc_status fill_ragged(pc_run *run, pc_json *facts) {
    pc_held_scan *scan = &run->product.scan;
    pc_ragged_stats stats;
    const pc_index given = scan->mesh.face_count;
    pc_status status = PC_OK;
    PC_TRY(pc_ragged_fill(&scan->mesh, &stats, run->ctx));
    PC_TRY(pc_resize(&scan->face_source, run->ctx, scan->mesh.face_count));
    for (pc_index f = given; f < scan->mesh.face_count; f++)
        scan->face_source[f] = PC_NONE;
    pc_json_integer(facts, "ragged_faces_added", stats.faces);
    pc_json_integer(facts, "ragged_holes_closed", stats.closed);
    if (stats.faces) {
        pc_stage_record *record = &run->record[PC_STAGE_SCAN];
        const size_t used = strlen(record->note);
        (void)snprintf(record->note + used, sizeof record->note - used, ", %u more fill ragged borders",
                       stats.faces);
        pc_log(run->ctx, PC_LOG_INFO,
               "%s: %u faces added in notches of ragged borders; %u holes closed by it", run->scan_path,
               stats.faces, stats.closed);
    }
done:
    return status;
}

static pc_status make(pc_run *run, pc_json *facts) {
    pc_repair_options options = PC_REPAIR_DEFAULTS;
    options.strict = run->options->strict;
    options.min_component = run->options->min_component;
    pc_held_scan *scan = &run->product.scan;
    pc_repair_report report = {0};
    pc_mesh raw = {0};
    pc_scan_info info;
    pc_status status = PC_OK;
    PC_TRY(pc_scan_read_bytes(&raw, &info, run->ctx, run->scan_path, run->input.data, run->input.size));
    pc_file_close(&run->input, run->ctx);
    status = pc_repair(&scan->mesh, &report, run->ctx, &raw, &options);
    if (status == PC_E_MESH) name_file(run);
    PC_TRY(status);
    pc_facts_put_file(facts, &info);
    pc_facts_put_repair(facts, "repair", &report);
    note(run, &report);
    scan->vertex_source = report.vertex_source, report.vertex_source = NULL;
    scan->face_source = report.face_source, report.face_source = NULL;
    if (!run->options->keep_ragged) PC_TRY(fill_ragged(run, facts));
done:
    pc_repair_report_free(&report, run->ctx);
    pc_mesh_free(&raw, run->ctx);
    return status;
}

static pc_status check(pc_run *run) {
    return pc_mesh_check(&run->product.scan.mesh, run->ctx);
}

static pc_status save(pc_run *run, pc_store *store) {
    const pc_held_scan *scan = &run->product.scan;
    pc_status status = PC_OK;
    PC_TRY(pc_mesh_save(store, "scan", &scan->mesh));
    PC_TRY(pc_indices_save(store, "scan/vertex_source", scan->vertex_source, scan->mesh.vertex_count,
                           "vertex of the file at each vertex"));
    PC_TRY(
        pc_indices_save(store, "scan/face_source", scan->face_source, scan->mesh.face_count,
                        "triangle of the file that each face is (a part of), polygons counted as triangles"));
done:
    return status;
}

static void drop(pc_run *run) {
    pc_held_scan *scan = &run->product.scan;
    pc_mesh_free(&scan->mesh, run->ctx);
    pc_free(run->ctx, scan->vertex_source);
    pc_free(run->ctx, scan->face_source);
    *scan = (pc_held_scan){0};
}

static pc_status load(pc_run *run, pc_store *store) {
    pc_held_scan *scan = &run->product.scan;
    pc_status status = PC_OK;
    *scan = (pc_held_scan){0};
    PC_TRY(pc_mesh_load(&scan->mesh, store, "scan"));
    size_t vertices = scan->mesh.vertex_count, faces = scan->mesh.face_count;
    PC_TRY(pc_indices_load(&scan->vertex_source, &vertices, store, "scan/vertex_source"));
    PC_TRY(pc_indices_load(&scan->face_source, &faces, store, "scan/face_source"));
done:
    if (status != PC_OK) drop(run);
    return status;
}

const pc_stage pc_stage_scan = {
    .name = "scan",
    .version = 1,
    .options = put_options,
    .make = make,
    .check = check,
    .save = save,
    .load = load,
    .drop = drop,
};
