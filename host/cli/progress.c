#include "progress.h"
#include "clock.h"
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { BAR_WIDTH = 30 };

static void clear_line(const pc_progress_view *view) {
    if (view->terminal && view->drawn > 0) (void)fprintf(stderr, "\r\033[K");
}

static void draw_bar(pc_progress_view *view, double fraction) {
    char bar[BAR_WIDTH + 1];
    if (fraction < 0) fraction = 0;
    if (fraction > 1) fraction = 1;
    for (int i = 0; i < BAR_WIDTH; i++)
        bar[i] = i < (int)(fraction * BAR_WIDTH) ? '#' : '.';
    bar[BAR_WIDTH] = '\0';
    view->drawn = pc_clock_wall();
    (void)fprintf(stderr, "\r\033[K[%d/%d] %-10s %s %3d %% %7.1f s", view->stage, view->stage_count,
                  view->title, bar, (int)(100 * fraction), view->drawn - view->started);
    (void)fflush(stderr);
}

static void on_fraction(void *user, double fraction) {
    pc_progress_view *view = user;
    if (!view->terminal || view->quiet || view->stage == 0) return;
    if (pc_clock_wall() - view->drawn > 0.1) draw_bar(view, fraction);
}

static void on_log(void *user, pc_log_level level, const char *line) {
    static const char *const prefix[] = {"error: ", "warning: ", "", ""};
    const pc_progress_view *view = user;
    clear_line(view);
    (void)fprintf(stderr, "percale: %s%s\n", prefix[level], line);
}

void pc_progress_start(pc_progress_view *view, pc_context *ctx, bool quiet, bool verbose) {
    *view = (pc_progress_view){.quiet = quiet, .verbose = verbose, .terminal = isatty(STDERR_FILENO) == 1};
    pc_context_set_log(ctx, on_log, view, quiet ? PC_LOG_ERROR : verbose ? PC_LOG_DEBUG : PC_LOG_WARNING);
    pc_context_set_progress(ctx, on_fraction, view);
}

void pc_progress_stage(void *user, const pc_stage_event *event) {
    pc_progress_view *view = user;
    if (view->quiet) return;
    if (!event->finished) {
        view->stage = event->number;
        view->stage_count = event->count;
        view->started = pc_clock_wall();
        (void)snprintf(view->title, sizeof view->title, "%s", event->name);
        if (view->terminal) draw_bar(view, 0);
        return;
    }
    clear_line(view);
    view->stage = 0;
    (void)fprintf(stderr, "[%d/%d] %-10s %8.2f s %7.0f MB  %s%s%s\n", event->number, event->count,
                  event->name, event->seconds, 1e-6 * (double)event->peak_bytes,
                  event->state == PC_STAGE_LOADED ? "kept" : "",
                  event->state == PC_STAGE_LOADED && event->note[0] ? ", " : "", event->note);
}

void pc_progress_stop(pc_progress_view *view, pc_context *ctx) {
    if (view->stage) clear_line(view);
    view->stage = 0;
    pc_context_set_log(ctx, NULL, NULL, PC_LOG_ERROR);
    pc_context_set_progress(ctx, NULL, NULL);
}
