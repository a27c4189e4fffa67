/* Monotonic wall time, CPU time of the process, peak resident memory. */
#ifndef PC_CLOCK_H
#define PC_CLOCK_H

#include <stddef.h>

double pc_clock_wall(void);       /* seconds since some fixed moment */
double pc_clock_cpu(void);        /* CPU seconds of this process, all threads */
size_t pc_clock_peak_bytes(void); /* the most memory this process had resident since the last reset */
void pc_clock_reset_peak(void);   /* where the system allows it (Linux), else nothing happens */

#endif
