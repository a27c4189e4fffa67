/* One result for the user out of the files of the stages. */
#ifndef PC_GATHER_H
#define PC_GATHER_H

#include "store.h"

/* Copies all groups and datasets of `stage` into `result`, under the same names; groups that both have are
 * merged, a dataset that both have is PC_E_BUG. The attributes of the stage's root (key, options, ...) go to
 * the group "stages/<title>". Datasets keep their layout and compression. */
pc_status pc_gather_stage(pc_store *result, pc_store *stage, const char *title);

#endif
