#include "run.h"
#include "clock.h"
#include "export.h"
#include "folder.h"
#include "memory.h"
#include "plan.h"
#include "stage.h"

static pc_status read_input(pc_run *run) {
    pc_sha256 hash;
    enum { STEP = 1 << 24 };
    pc_status status = pc_file_open(&run->input, run->ctx, run->scan_path);
    if (status != PC_OK) return status;
    pc_sha256_start(&hash);
    for (size_t at = 0; at < run->input.size && status == PC_OK; at += STEP) {
        pc_sha256_add(&hash, run->input.data + at, run->input.size - at < STEP ? run->input.size - at : STEP);
        status = pc_check_interrupt(run->ctx);
    }
    pc_sha256_finish(run->input_sha256, &hash);
    run->input_bytes = run->input.size;
    return status;
}

static pc_status look_for_kept(pc_run *run) {
    pc_status status = PC_OK;
    for (int id = 0; id < PC_STAGE_EXPORT; id++) {
        pc_stage_id stage = (pc_stage_id)id;
        if (!pc_stage_wanted(stage, run->options)) {
            run->record[stage].state = PC_STAGE_SKIPPED;
            continue;
        }
        PC_TRY(pc_stage_make_key(run, stage));
        if (run->options->resume) PC_TRY(pc_stage_look(run, stage));
    }
done:
    return status;
}

/* True where a stage after `finished` will be made and reads the product of `stage`. */
static bool needed_after(const pc_run *run, pc_stage_id finished, pc_stage_id stage) {
    for (int id = (int)finished + 1; id < PC_STAGE_EXPORT; id++)
        if (!run->kept[id] && run->record[id].state != PC_STAGE_SKIPPED &&
            pc_stages[id]->needs & PC_NEEDS(stage))
            return true;
    return false;
}

static void drop_unneeded(pc_run *run, pc_stage_id finished) {
    for (int id = 0; id <= (int)finished; id++)
        if (!needed_after(run, finished, (pc_stage_id)id)) pc_stage_drop(run, (pc_stage_id)id);
}

static void tell(const pc_run *run, pc_stage_id stage, bool finished) {
    const pc_stage_record *record = &run->record[stage];
    pc_stage_event event = {.stage = stage,
                            .name = pc_stage_title(stage),
                            .finished = finished,
                            .state = record->state,
                            .seconds = record->wall_seconds,
                            .peak_bytes = record->resident_peak,
                            .note = record->note};
    if (!run->options->on_stage) return;
    for (int id = 0; id < PC_STAGE_COUNT; id++) {
        if (run->record[id].state == PC_STAGE_SKIPPED) continue;
        event.count++;
        event.number += id <= (int)stage;
    }
    run->options->on_stage(run->options->user, &event);
}

typedef struct stopwatch {
    double wall, cpu;
} stopwatch;

static stopwatch start_stage(pc_run *run, pc_stage_id stage) {
    pc_memory_reset_peak(run->ctx);
    pc_clock_reset_peak();
    tell(run, stage, false);
    return (stopwatch){pc_clock_wall(), pc_clock_cpu()};
}

static void finish_stage(pc_run *run, pc_stage_id stage, stopwatch start, pc_stage_state state) {
    pc_stage_record *record = &run->record[stage];
    record->state = state;
    record->wall_seconds = pc_clock_wall() - start.wall;
    record->cpu_seconds = pc_clock_cpu() - start.cpu;
    record->counted_peak = pc_memory_peak(run->ctx);
    record->resident_peak = pc_clock_peak_bytes();
    tell(run, stage, true);
}

static pc_status stop_where_asked(pc_run *run, pc_stage_id stage) {
    if (run->options->stop_after == stage) pc_context_interrupt(run->ctx);
    return pc_check_interrupt(run->ctx);
}

static pc_status run_stage(pc_run *run, pc_stage_id stage) {
    pc_status status = PC_OK;
    stopwatch start = start_stage(run, stage);
    if (run->kept[stage]) {
        finish_stage(run, stage, start, PC_STAGE_LOADED);
        return PC_OK;
    }
    for (int need = 0; need < (int)stage; need++)
        if (pc_stages[stage]->needs & PC_NEEDS(need) && run->record[need].state != PC_STAGE_SKIPPED)
            PC_TRY(pc_stage_hold(run, (pc_stage_id)need));
    PC_TRY(pc_stage_make(run, stage));
    drop_unneeded(run, stage);
    finish_stage(run, stage, start, PC_STAGE_MADE);
done:
    return status;
}

static pc_status run_all(pc_run *run) {
    pc_status status = PC_OK;
    for (int id = 0; id < PC_STAGE_EXPORT; id++) {
        if (run->record[id].state == PC_STAGE_SKIPPED) continue;
        PC_TRY(run_stage(run, (pc_stage_id)id));
        PC_TRY(stop_where_asked(run, (pc_stage_id)id));
    }
done:
    return status;
}

static void free_run(pc_run *run) {
    for (int id = 0; id < PC_STAGE_EXPORT; id++) {
        pc_stages[id]->drop(run);
        pc_free(run->ctx, run->record[id].facts);
    }
    pc_free(run->ctx, run->kernels);
    pc_file_close(&run->input, run->ctx);
    pc_device_close(run->device, run->ctx);
}

pc_status pc_convert(char **report, pc_context *ctx, const char *scan, const char *out,
                     const pc_convert_options *options) {
    pc_run run = {.ctx = ctx, .options = options, .scan_path = scan, .out = out};
    pc_status status = PC_OK;
    pc_folder folder = {.lock = -1};
    *report = NULL;
    PC_TRY(read_input(&run));
    PC_TRY(pc_device_open(&run.device, ctx, options->device));
    PC_TRY(pc_folder_prepare(&folder, ctx, out, options->resume, options->force));
    PC_TRY(look_for_kept(&run));
    PC_TRY(run_all(&run));
    stopwatch start = start_stage(&run, PC_STAGE_EXPORT);
    status = pc_export(report, &run);
    if (status == PC_OK || status == PC_E_NOCONV) finish_stage(&run, PC_STAGE_EXPORT, start, PC_STAGE_MADE);
done:
    pc_folder_release(&folder, ctx, status != PC_OK);
    free_run(&run);
    return status;
}

pc_status pc_convert_estimate(pc_convert_plan *plan, pc_context *ctx, const char *scan,
                              const pc_convert_options *options) {
    pc_run run = {.ctx = ctx, .options = options, .scan_path = scan};
    pc_status status = PC_OK;
    *plan = (pc_convert_plan){0};
    PC_TRY(read_input(&run));
    PC_TRY(pc_device_open(&run.device, ctx, "host"));
    PC_TRY(pc_stage_make(&run, PC_STAGE_SCAN));
    PC_TRY(pc_plan_make(plan, &run));
done:
    free_run(&run);
    return status;
}
