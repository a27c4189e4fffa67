/* The output folder: refused where something would be overwritten, cleared of the results of earlier runs. */
#ifndef PC_FOLDER_H
#define PC_FOLDER_H

#include "context.h"

/* Names of the files in the folder. */
#define PC_OUT_STAGES  "stages"
#define PC_OUT_REPORT  "report.json"
#define PC_OUT_PAGE    "report.html"
#define PC_OUT_RESULT  "result.h5"
#define PC_OUT_SURFACE "surface" /* and an ending */
#define PC_OUT_CAGE    "cage.obj"

/* `folder`/`name``ending`; free with pc_free. */
pc_status pc_folder_join(char **path, pc_context *ctx, const char *folder, const char *name,
                         const char *ending);
/* A folder that a run has for itself. */
typedef struct pc_folder {
    const char *path; /* borrowed */
    int lock;         /* a file descriptor; -1 where the file system knows no locks */
    bool made, ready; /* the folder was not there before; it is this run's */
} pc_folder;

/* Makes the folder and those above it, and `stages` in it. PC_E_USAGE where it holds anything, unless `force`
 * is set, or `resume` and it is the folder of an earlier run; also where another run is at work there. Files
 * that an export wrote there are removed; stage files too unless `resume`. PC_E_IO. Other runs are kept out
 * until it is released or the process ends. */
pc_status pc_folder_prepare(pc_folder *held, pc_context *ctx, const char *folder, bool resume, bool force);
/* After a run that failed, folders that hold nothing are taken away again, so that the next one finds no
 * folder in its way. */
void pc_folder_release(pc_folder *held, pc_context *ctx, bool failed);

#endif
