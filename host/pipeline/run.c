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

/* Stages before `first` are as they were. */
static pc_status look_for_kept(pc_run *run, pc_stage_id first) {
    pc_status status = PC_OK;
    for (int id = (int)first; id < PC_STAGE_EXPORT; id++) {
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

static size_t larger(size_t a, size_t b) {
    return a > b ? a : b;
}

static void finish_stage(pc_run *run, pc_stage_id stage, stopwatch start, pc_stage_state state) {
    pc_stage_record *record = &run->record[stage];
    record->state = state;
    record->wall_seconds += pc_clock_wall() - start.wall; /* of all tries */
    record->cpu_seconds += pc_clock_cpu() - start.cpu;
    record->counted_peak = larger(record->counted_peak, pc_memory_peak(run->ctx));
    record->resident_peak = larger(record->resident_peak, pc_clock_peak_bytes());
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

static pc_status run_from(pc_run *run, pc_stage_id first) {
    pc_status status = PC_OK;
    for (int id = (int)first; id < PC_STAGE_EXPORT; id++) {
        if (run->record[id].state == PC_STAGE_SKIPPED) continue;
        PC_TRY(run_stage(run, (pc_stage_id)id));
        PC_TRY(stop_where_asked(run, (pc_stage_id)id));
    }
done:
    return status;
}

/* The stages from the parameterization on, with other options; an earlier run may have left them. */
static pc_status change_options(pc_run *run, const pc_convert_options *options) {
    run->options = options;
    for (int id = PC_STAGE_PARAM; id < PC_STAGE_EXPORT; id++) {
        pc_stage_drop(run, (pc_stage_id)id);
        pc_free(run->ctx, run->record[id].facts);
        run->record[id].facts = NULL;
        run->kept[id] = false;
    }
    return look_for_kept(run, PC_STAGE_PARAM);
}

/* The user has chosen neither the size of the quads nor a budget. */
static bool may_try_closer(const pc_convert_options *o) {
    return o->tolerance > 0 && o->last >= PC_STAGE_SPLINE && !o->quads && !(o->edge_length > 0) &&
           !(o->edge_factor > 0) && !o->max_control_points;
}

/* The options of the try that comes after the one with run->options; NULL: that one stands. */
static const pc_convert_options *next_try(const pc_run *run, const pc_convert_options *usual,
                                          const pc_convert_options *closer) {
    const pc_index most_faces = 1000000; /* of a scan that is tried again */
    const pc_held_spline *spline = &run->product.spline;
    const double error = spline->stats.accuracy.max, other = spline->earlier_error;
    if (run->options == closer) return error > other ? usual : NULL;
    if (error <= spline->tolerance || other > 0 || spline->stats.full) return NULL;
    return run->product.mesh.mesh.face_count <= most_faces ? closer : NULL;
}

/* Where the spline misses the tolerance it is made again from quads that follow the scan more closely; where
 * that is no better, as it was. */
static pc_status improve(pc_run *run, const pc_convert_options *usual, const pc_convert_options *closer) {
    pc_status status = PC_OK;
    for (;;) {
        PC_TRY(pc_stage_hold(run, PC_STAGE_SPLINE));
        const pc_convert_options *next = next_try(run, usual, closer);
        if (!next) break;
        run->earlier_error = run->product.spline.stats.accuracy.max;
        pc_log(run->ctx, PC_LOG_WARNING, "%g from the scan, not %g: %s", run->earlier_error,
               run->product.spline.tolerance,
               next == closer ? "once more, from quads that follow it more closely"
                              : "no better, so the first try again");
        PC_TRY(change_options(run, next));
        PC_TRY(run_from(run, PC_STAGE_PARAM));
    }
done:
    return status;
}

/* An earlier run may have ended with the other try. */
static pc_status look_for_closer(pc_run *run, const pc_convert_options *usual,
                                 const pc_convert_options *closer) {
    pc_status status = PC_OK;
    if (!usual->resume || run->kept[PC_STAGE_PARAM]) return PC_OK;
    PC_TRY(change_options(run, closer));
    if (!run->kept[PC_STAGE_SPLINE]) PC_TRY(change_options(run, usual));
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
    pc_convert_options closer = *options;
    pc_status status = PC_OK;
    closer.closer = true;
    pc_folder folder = {.lock = -1};
    *report = NULL;
    PC_TRY(read_input(&run));
    PC_TRY(pc_device_open(&run.device, ctx, options->device));
    PC_TRY(pc_folder_prepare(&folder, ctx, out, options->resume, options->force));
    PC_TRY(look_for_kept(&run, PC_STAGE_SCAN));
    if (may_try_closer(options)) PC_TRY(look_for_closer(&run, options, &closer));
    PC_TRY(run_from(&run, PC_STAGE_SCAN));
    if (may_try_closer(options)) PC_TRY(improve(&run, options, &closer));
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
