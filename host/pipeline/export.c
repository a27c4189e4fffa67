#include "export.h"
#include "folder.h"
#include "gather.h"
#include "html_report.h"
#include "memory.h"
#include "polyfile.h"
#include "previews.h"
#include "report.h"
#include "user_order.h"
#include "version.h"
#include "vtkhdf.h"
#include <stdio.h>
#include <string.h>

static bool finished(const pc_run *run, pc_stage_id stage) {
    return run->record[stage].state == PC_STAGE_MADE || run->record[stage].state == PC_STAGE_LOADED;
}

static void certify(pc_findings *findings, const pc_run *run) {
    const pc_convert_options *wish = run->options;
    pc_certificate_options options = PC_CERTIFICATE_DEFAULTS;
    options.faces_asked = (double)wish->quads;
    /* Cells that are split become quads of half their side. */
    options.edge_length = run->product.param.period_length * (wish->keep_ngons ? 1 : 0.5);
    pc_certificate_make(&findings->certificate, &findings->quality, &run->product.field, &options);
}

static pc_status measure(pc_findings *findings, pc_run *run) {
    const pc_held *p = &run->product;
    pc_status status = PC_OK;
    if (finished(run, PC_STAGE_PARAM)) {
        PC_TRY(pc_stage_hold(run, PC_STAGE_PARAM));
        PC_TRY(pc_distortion_measure(&findings->distortion, run->ctx, &p->mesh.mesh, &p->param));
        findings->has_distortion = true;
    }
    if (finished(run, PC_STAGE_QUADS)) {
        PC_TRY(pc_stage_hold(run, PC_STAGE_FIELD));
        PC_TRY(pc_stage_hold(run, PC_STAGE_QUADS));
        const pc_quality_input input = {.scan = &p->mesh.mesh, .quads = &p->quads, .field = &p->field};
        PC_TRY(pc_quality_measure(&findings->quality, run->ctx, &input));
        certify(findings, run);
        findings->has_quality = true;
    }
    if (finished(run, PC_STAGE_SPLINE)) {
        PC_TRY(pc_stage_hold(run, PC_STAGE_SPLINE));
        PC_TRY(pc_spline_findings_make(&findings->spline, run));
        pc_spline_findings_certify(&findings->certificate, &p->spline, run->options->max_control_points);
        findings->has_spline = true;
    }
done:
    return status;
}

static pc_status put_json(pc_store *store, pc_run *run, const char *name, const pc_findings *findings) {
    pc_json json;
    pc_json_start(&json, run->ctx, true);
    if (strcmp(name, "statistics") == 0)
        pc_report_put_statistics(&json, NULL, findings);
    else
        pc_report_put_certificate(&json, NULL, &findings->certificate);
    pc_status status = pc_json_end(&json);
    if (status == PC_OK) status = pc_store_set_text(store, "/", name, json.text);
    pc_json_free(&json);
    return status;
}

static pc_status gather(pc_store *result, pc_run *run, pc_stage_id stage) {
    pc_store *store;
    pc_status status = pc_stage_open(&store, run, stage);
    if (status == PC_OK) status = pc_gather_stage(result, store, pc_stage_title(stage));
    pc_store_close(store);
    return status;
}

static pc_status write_result(pc_run *run, const pc_findings *findings) {
    const pc_store_options options = {.force = true, .compress = run->options->compress};
    char *path = NULL, program[32];
    pc_store *store = NULL;
    pc_status status = PC_OK;
    (void)snprintf(program, sizeof program, "percale %s", pc_version());
    PC_TRY(pc_folder_join(&path, run->ctx, run->out, PC_OUT_RESULT, ""));
    PC_TRY(pc_store_create(&store, run->ctx, path, &options));
    PC_TRY(pc_store_set_text(store, "/", "program", program));
    PC_TRY(pc_store_set_text(store, "/", "input_sha256", run->input_sha256));
    PC_TRY(pc_store_set_text(store, "/", "device", pc_device_name(run->device)));
    for (int id = 0; id < PC_STAGE_EXPORT; id++)
        if (id != PC_STAGE_PARTS && finished(run, (pc_stage_id)id))
            PC_TRY(gather(store, run, (pc_stage_id)id));
    PC_TRY(put_json(store, run, "statistics", findings));
    if (findings->has_quality) PC_TRY(put_json(store, run, "certificate", findings));
    PC_TRY(pc_store_commit(&store));
done:
    pc_store_close(store);
    pc_free(run->ctx, path);
    return status;
}

static pc_status write_quads(pc_run *run) {
    const pc_store_options options = {.force = true, .compress = run->options->compress};
    char *obj = NULL, *ply = NULL, *hdf = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_stage_hold(run, PC_STAGE_QUADS));
    const pc_polymesh *quads = &run->product.quads;
    PC_TRY(pc_folder_join(&obj, run->ctx, run->out, "quads.obj", ""));
    PC_TRY(pc_polyfile_write_obj(run->ctx, quads, obj, true));
    PC_TRY(pc_folder_join(&ply, run->ctx, run->out, "quads.ply", ""));
    PC_TRY(pc_polyfile_write_ply(run->ctx, quads, ply, true));
    PC_TRY(pc_folder_join(&hdf, run->ctx, run->out, "quads.hdf", ""));
    PC_TRY(pc_vtkhdf_write_polygons(run->ctx, hdf, quads, NULL, 0, &options));
done:
    pc_free(run->ctx, obj);
    pc_free(run->ctx, ply);
    pc_free(run->ctx, hdf);
    return status;
}

/* scan.hdf: the scan, long edges split, in the user's order, with all that is known on it. */
static pc_status write_scan(pc_run *run) {
    const pc_store_options options = {.force = true, .compress = run->options->compress};
    const pc_held *p = &run->product;
    const bool has_curvature = finished(run, PC_STAGE_CURVATURE), has_field = finished(run, PC_STAGE_FIELD),
               has_param = finished(run, PC_STAGE_PARAM);
    pc_mesh mesh = {0};
    pc_curvature curvature = {0};
    pc_field field = {0};
    pc_param param = {0};
    char *path = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_stage_hold(run, PC_STAGE_MESH));
    const pc_renumbering to_user = pc_to_user_order(&p->mesh);
    PC_TRY(pc_renumber_mesh(&mesh, run->ctx, &p->mesh.mesh, &to_user));
    if (has_curvature) PC_TRY(pc_stage_hold(run, PC_STAGE_CURVATURE));
    if (has_curvature) PC_TRY(pc_renumber_curvature(&curvature, run->ctx, &p->curvature, &to_user));
    if (has_field) PC_TRY(pc_stage_hold(run, PC_STAGE_FIELD));
    if (has_field) PC_TRY(pc_renumber_field(&field, run->ctx, &p->field, &to_user));
    if (has_param) PC_TRY(pc_stage_hold(run, PC_STAGE_PARAM));
    if (has_param) PC_TRY(pc_renumber_param(&param, run->ctx, &p->param, &to_user));
    PC_TRY(pc_folder_join(&path, run->ctx, run->out, "scan.hdf", ""));
    PC_TRY(pc_vtkhdf_write_scan(run->ctx, path, &mesh, has_curvature ? &curvature : NULL,
                                has_field ? &field : NULL, has_param ? &param : NULL, &options));
done:
    pc_free(run->ctx, path);
    pc_param_free(&param, run->ctx);
    pc_field_free(&field, run->ctx);
    pc_curvature_free(&curvature, run->ctx);
    pc_mesh_free(&mesh, run->ctx);
    return status;
}

static pc_status write_pictures(pc_album *album, pc_run *run) {
    static const pc_preview_kind order[PC_PREVIEW_COUNT] = {
        PC_PREVIEW_SCAN,  PC_PREVIEW_FIELD,   PC_PREVIEW_CURVATURE, PC_PREVIEW_ISOLINES, PC_PREVIEW_LAYOUT,
        PC_PREVIEW_QUADS, PC_PREVIEW_SURFACE, PC_PREVIEW_ZEBRA,     PC_PREVIEW_ERROR};
    const bool needs_mesh = finished(run, PC_STAGE_MESH);
    pc_status status = PC_OK;
    if (!run->options->pictures || !needs_mesh) return PC_OK;
    PC_TRY(pc_stage_hold(run, PC_STAGE_MESH));
    for (int what = 0; what < PC_PREVIEW_COUNT; what++) {
        const pc_preview_kind kind = order[what];
        const pc_stage_id stage = pc_preview_stage(kind);
        if (!finished(run, stage)) continue;
        PC_TRY(pc_stage_hold(run, stage));
        PC_TRY(pc_preview_draw(album, run->ctx, &run->product, kind));
        if (stage == PC_STAGE_CURVATURE || stage == PC_STAGE_LAYOUT) pc_stage_drop(run, stage);
    }
    PC_TRY(pc_album_write(album, run));
done:
    return status;
}

static pc_status write_report(char **report, pc_run *run, const pc_findings *findings) {
    pc_json json;
    char *path = NULL;
    pc_writer writer = {0};
    pc_status status = PC_OK;
    pc_json_start(&json, run->ctx, false);
    PC_TRY(pc_report_make(&json, run, findings));
    PC_TRY(pc_folder_join(&path, run->ctx, run->out, PC_OUT_REPORT, ""));
    PC_TRY(pc_writer_open(&writer, run->ctx, path, true));
    PC_TRY(pc_writer_put(&writer, json.text, json.length));
    PC_TRY(pc_writer_commit(&writer));
    *report = json.text, json.text = NULL;
done:
    pc_writer_abandon(&writer);
    pc_free(run->ctx, path);
    pc_json_free(&json);
    return status;
}

static pc_status fail_certificate(pc_context *ctx, const pc_certificate *certificate) {
    char names[512] = "";
    for (int i = 0; i < certificate->count; i++) {
        const pc_check *check = &certificate->check[i];
        size_t used = strlen(names);
        if (!check->passed)
            (void)snprintf(names + used, sizeof names - used, "%s%s (%s: %.6g, expected %.6g)",
                           used ? ", " : "", check->name, check->note, check->value, check->expected);
    }
    return pc_fail(ctx, PC_E_NOCONV, "the result misses what it should keep: %s; all outputs are written",
                   names);
}

pc_status pc_export(char **report, pc_run *run) {
    pc_findings findings = {0};
    pc_album album = {0};
    pc_spline_texts texts = {0};
    pc_status status = PC_OK;
    *report = NULL;
    PC_TRY(measure(&findings, run));
    if (findings.has_spline) pc_spline_texts_start(&texts, run, &findings.spline);
    pc_progress(run->ctx, 0.4);
    PC_TRY(write_result(run, &findings));
    pc_progress(run->ctx, 0.6);
    if (finished(run, PC_STAGE_QUADS)) PC_TRY(write_quads(run));
    if (findings.has_spline) PC_TRY(pc_spline_skin_write(run));
    if (finished(run, PC_STAGE_MESH)) PC_TRY(write_scan(run));
    pc_progress(run->ctx, 0.8);
    PC_TRY(write_pictures(&album, run));
    PC_TRY(pc_check_interrupt(run->ctx));
    if (findings.has_spline) PC_TRY(pc_album_measure(&album, run->ctx, &run->product));
    PC_TRY(pc_spline_texts_finish(&texts));
    PC_TRY(pc_html_report_write(run, &findings, &album));
    PC_TRY(write_report(report, run, &findings));
    if (findings.has_quality && !findings.certificate.passed)
        status = fail_certificate(run->ctx, &findings.certificate);
done:
    (void)pc_spline_texts_finish(&texts);
    pc_album_free(&album, run->ctx);
    pc_spline_findings_free(&findings.spline, run->ctx);
    return status;
}
