/* What a run tells of its spline, and the files that hold it for others. */
#ifndef PC_SPLINE_FILES_H
#define PC_SPLINE_FILES_H

#include "certificate.h"
#include "continuity.h"
#include "measure.h"
#include "shell.h"
#include "stage.h"
#include <pthread.h>

typedef struct pc_spline_findings {
    const pc_held_spline *held; /* borrowed */
    pc_shell shell;
    pc_jump jump[PC_JOINT_COUNT];
    pc_measure measure;
} pc_spline_findings;

/* Of the spline that the run holds. PC_E_NOMEM, PC_E_BUG where the shell is not one. */
pc_status pc_spline_findings_make(pc_spline_findings *findings, pc_run *run);
void pc_spline_findings_free(pc_spline_findings *findings, pc_context *ctx);
/* Member "spline" of the report's statistics. */
void pc_spline_findings_put(pc_json *json, const pc_spline_findings *findings);
/* Checks "spline tolerance", "control points" (unless `most_points` is 0) and "spline basis". */
void pc_spline_findings_certify(pc_certificate *certificate, const pc_held_spline *spline,
                                pc_index most_points);

/* surface.hdf: triangles, with their distance to the scan. PC_E_IO. */
pc_status pc_spline_skin_write(pc_run *run);

/* surface.step, cage.obj (control mesh for modelling programs), and the further formats that the options ask
 * for, written while the caller does something else. */
typedef struct pc_spline_texts {
    pc_run *run; /* NULL: nothing is under way */
    const pc_spline_findings *findings;
    pthread_t thread;
    bool apart; /* there is a thread */
    pc_status status;
} pc_spline_texts;

/* Run and findings stay as they are until pc_spline_texts_finish. */
void pc_spline_texts_start(pc_spline_texts *texts, pc_run *run, const pc_spline_findings *findings);
/* Waits for the end. PC_E_IO, PC_E_NOMEM; PC_OK where nothing was started. */
pc_status pc_spline_texts_finish(pc_spline_texts *texts);

#endif
