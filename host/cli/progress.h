/* What the user sees while stages run: a bar on a terminal, one line per stage in a log. */
#ifndef PC_PROGRESS_H
#define PC_PROGRESS_H

#include "run.h"

typedef struct pc_progress_view {
    bool quiet;
    bool verbose;
    bool terminal; /* stderr is one */
    int stage;     /* number of the running stage, from 1; 0: none */
    int stage_count;
    char title[32];
    double started;
    double drawn; /* when the bar was last drawn */
} pc_progress_view;

/* Sends the log and the progress of ctx, and the stages of a run, to stderr. */
void pc_progress_start(pc_progress_view *view, pc_context *ctx, bool quiet, bool verbose);
/* The sink of pc_convert_options.on_stage. */
void pc_progress_stage(void *view, const pc_stage_event *event);
/* Clears a bar that is left on the terminal. */
void pc_progress_stop(pc_progress_view *view, pc_context *ctx);

#endif
