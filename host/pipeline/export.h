/* The end of a run: results for the user out of the products of the stages. */
#ifndef PC_EXPORT_H
#define PC_EXPORT_H

#include "stage.h"

/* Writes whatever the finished stages allow: result.h5, quads.obj, .ply and .hdf, scan.hdf, pictures, and
 * report.json last. `*report` receives the text of the latter. PC_E_NOCONV, all files written, where a check
 * of the certificate failed. */
pc_status pc_export(char **report, pc_run *run);

#endif
