#include "stage.h"
#include "clock.h"
#include "folder.h"
#include "memory.h"
#include "version.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

const pc_stage *const pc_stages[PC_STAGE_EXPORT] = {
    [PC_STAGE_SCAN] = &pc_stage_scan,   [PC_STAGE_MESH] = &pc_stage_mesh,
    [PC_STAGE_PARTS] = &pc_stage_parts, [PC_STAGE_CURVATURE] = &pc_stage_curvature,
    [PC_STAGE_FIELD] = &pc_stage_field, [PC_STAGE_CURL] = &pc_stage_curl,
    [PC_STAGE_PARAM] = &pc_stage_param, [PC_STAGE_LAYOUT] = &pc_stage_layout,
    [PC_STAGE_QUADS] = &pc_stage_quads, [PC_STAGE_SPLINE] = &pc_stage_spline,
};

const char *pc_stage_title(pc_stage_id stage) {
    return stage < PC_STAGE_EXPORT ? pc_stages[stage]->name : "export";
}

pc_stage_id pc_stage_find(const char *name) {
    int stage = 0;
    while (stage < PC_STAGE_COUNT && strcmp(pc_stage_title((pc_stage_id)stage), name) != 0)
        stage++;
    return (pc_stage_id)stage;
}

bool pc_stage_wanted(pc_stage_id stage, const pc_convert_options *options) {
    if (stage > options->last) return false;
    return !pc_stages[stage]->wanted || pc_stages[stage]->wanted(options);
}

/* The options of a stage as text, the same for the same options. */
static pc_status canonical_options(char **text, pc_run *run, const pc_stage *stage) {
    pc_json json;
    pc_json_start(&json, run->ctx, true);
    pc_json_object(&json, NULL);
    if (stage->options) stage->options(&json, run->options);
    pc_json_close(&json);
    pc_status status = pc_json_end(&json);
    if (status != PC_OK) pc_json_free(&json);
    *text = json.text;
    return status;
}

pc_status pc_stage_make_key(pc_run *run, pc_stage_id id) {
    const pc_stage *stage = pc_stages[id];
    char *options, version[16];
    pc_sha256 hash;
    pc_status status = canonical_options(&options, run, stage);
    if (status != PC_OK) return status;
    (void)snprintf(version, sizeof version, "%d", stage->version);
    pc_sha256_start(&hash);
    pc_sha256_add_text(&hash, stage->name);
    pc_sha256_add_text(&hash, version);
    pc_sha256_add_text(&hash, options);
    if (id == PC_STAGE_SCAN) pc_sha256_add_text(&hash, run->input_sha256);
    for (int need = 0; need < PC_STAGE_EXPORT; need++)
        if (stage->needs & PC_NEEDS(need))
            pc_sha256_add_text(&hash, pc_stage_wanted((pc_stage_id)need, run->options) ? run->key[need] : "");
    pc_sha256_finish(run->key[id], &hash);
    pc_free(run->ctx, options);
    return PC_OK;
}

static pc_status stage_path(char **path, const pc_run *run, pc_stage_id stage) {
    char *folder = NULL;
    *path = NULL;
    pc_status status = pc_folder_join(&folder, run->ctx, run->out, PC_OUT_STAGES, "");
    if (status == PC_OK) status = pc_folder_join(path, run->ctx, folder, pc_stage_title(stage), ".h5");
    pc_free(run->ctx, folder);
    return status;
}

pc_status pc_stage_open(pc_store **store, pc_run *run, pc_stage_id stage) {
    char *path;
    *store = NULL;
    pc_status status = stage_path(&path, run, stage);
    if (status == PC_OK) status = pc_store_open(store, run->ctx, path);
    pc_free(run->ctx, path);
    return status;
}

static pc_status read_record(bool *fits, pc_run *run, pc_store *store, pc_stage_id stage) {
    char *key = NULL, *note = NULL;
    pc_stage_record *record = &run->record[stage];
    pc_status status = PC_OK;
    *fits = false;
    PC_TRY(pc_store_get_text(&key, store, "/", "key"));
    if (strcmp(key, run->key[stage]) != 0) goto done;
    PC_TRY(pc_store_get_text(&note, store, "/", "note"));
    PC_TRY(pc_store_get_text(&record->facts, store, "/", "facts"));
    (void)snprintf(record->note, sizeof record->note, "%s", note);
    *fits = true;
done:
    pc_free(run->ctx, key);
    pc_free(run->ctx, note);
    return status;
}

pc_status pc_stage_look(pc_run *run, pc_stage_id stage) {
    char *path = NULL;
    pc_store *store = NULL;
    pc_status status = PC_OK;
    run->kept[stage] = false;
    PC_TRY(stage_path(&path, run, stage));
    if (access(path, F_OK) != 0) goto done;
    status = pc_store_open(&store, run->ctx, path);
    if (status == PC_OK) status = read_record(&run->kept[stage], run, store, stage);
    if (status == PC_E_FORMAT || status == PC_E_IO) {
        pc_log(run->ctx, PC_LOG_WARNING, "%s; the stage is made again", pc_context_message(run->ctx));
        pc_context_clear_message(run->ctx);
        status = PC_OK;
    }
done:
    pc_store_close(store);
    pc_free(run->ctx, path);
    return status;
}

pc_status pc_stage_hold(pc_run *run, pc_stage_id stage) {
    pc_store *store = NULL;
    pc_status status = PC_OK;
    if (run->held[stage]) return PC_OK;
    /* Files are in the user's order; the mesh knows the other. */
    if (pc_stages[stage]->needs & PC_NEEDS(PC_STAGE_MESH)) PC_TRY(pc_stage_hold(run, PC_STAGE_MESH));
    PC_TRY(pc_stage_open(&store, run, stage));
    PC_TRY(pc_stages[stage]->load(run, store));
    run->held[stage] = true;
done:
    pc_store_close(store);
    return status;
}

void pc_stage_drop(pc_run *run, pc_stage_id stage) {
    if (run->held[stage]) pc_stages[stage]->drop(run);
    run->held[stage] = false;
}

static pc_status save_header(pc_run *run, pc_store *store, pc_stage_id id) {
    char *options = NULL, program[32];
    pc_status status = PC_OK;
    (void)snprintf(program, sizeof program, "percale %s", pc_version());
    PC_TRY(canonical_options(&options, run, pc_stages[id]));
    PC_TRY(pc_store_set_text(store, "/", "stage", pc_stages[id]->name));
    PC_TRY(pc_store_set_int(store, "/", "stage_version", pc_stages[id]->version));
    PC_TRY(pc_store_set_text(store, "/", "key", run->key[id]));
    PC_TRY(pc_store_set_text(store, "/", "program", program));
    PC_TRY(pc_store_set_text(store, "/", "options", options));
    PC_TRY(pc_store_set_text(store, "/", "input_sha256", run->input_sha256));
    PC_TRY(pc_store_set_text(store, "/", "device", pc_device_name(run->device)));
    PC_TRY(pc_store_set_text(store, "/", "note", run->record[id].note));
    PC_TRY(pc_store_set_text(store, "/", "facts", run->record[id].facts));
done:
    pc_free(run->ctx, options);
    return status;
}

static pc_status save_product(pc_run *run, pc_stage_id id) {
    const pc_store_options options = {.force = true, .compress = run->options->compress};
    char *path = NULL;
    pc_store *store = NULL;
    pc_status status = PC_OK;
    PC_TRY(stage_path(&path, run, id));
    PC_TRY(pc_store_create(&store, run->ctx, path, &options));
    PC_TRY(save_header(run, store, id));
    PC_TRY(pc_stages[id]->save(run, store));
    PC_TRY(pc_store_commit(&store));
done:
    pc_store_close(store);
    pc_free(run->ctx, path);
    return status;
}

/* To what it did in an earlier try of the stage. */
static void add_kernel(pc_run *run, pc_stage_id stage, const pc_kernel_stats *stats) {
    for (size_t i = 0; i < run->kernel_count; i++) {
        pc_kernel_record *known = &run->kernels[i];
        if (known->stage != stage || strcmp(known->stats.name, stats->name) != 0) continue;
        known->stats.count += stats->count;
        known->stats.seconds += stats->seconds;
        known->stats.bytes += stats->bytes;
        return;
    }
    run->kernels[run->kernel_count++] = (pc_kernel_record){.stage = stage, .stats = *stats};
}

static pc_status keep_kernels(pc_run *run, pc_stage_id stage) {
    const pc_kernel_stats *table;
    size_t count;
    pc_status status = pc_device_kernel_stats(&table, &count, run->ctx, run->device);
    if (status == PC_OK) status = pc_resize(&run->kernels, run->ctx, run->kernel_count + count);
    for (size_t i = 0; status == PC_OK && i < count; i++)
        if (table[i].count > 0) add_kernel(run, stage, &table[i]);
    return status;
}

pc_status pc_stage_make(pc_run *run, pc_stage_id id) {
    const pc_stage *stage = pc_stages[id];
    pc_stage_record *record = &run->record[id];
    pc_json facts;
    pc_status status = PC_OK;
    pc_json_start(&facts, run->ctx, true);
    pc_json_object(&facts, NULL);
    pc_device_reset_stats(run->device);
    status = stage->make(run, &facts);
    if (status != PC_OK) {
        pc_json_free(&facts);
        return status;
    }
    run->held[id] = true;
    pc_json_close(&facts);
    status = pc_json_end(&facts);
    pc_free(run->ctx, record->facts);
    record->facts = facts.text;
    PC_TRY(status);
    PC_TRY(stage->check(run));
    PC_TRY(keep_kernels(run, id));
    if (run->out) PC_TRY(save_product(run, id));
done:
    return status;
}
