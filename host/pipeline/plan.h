/* What a conversion would give and take. */
#ifndef PC_PLAN_H
#define PC_PLAN_H

#include "stage.h"

/* The edge length of the quads that the options ask for, model units. */
double pc_plan_edge(const pc_convert_options *options, double area, double mean_edge);
/* From the scan that `run` holds. */
pc_status pc_plan_make(pc_convert_plan *plan, pc_run *run);

#endif
