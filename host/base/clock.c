#include "clock.h"
#include <fcntl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

static double seconds(clockid_t clock) {
    struct timespec now;
    (void)clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double pc_clock_wall(void) {
    return seconds(CLOCK_MONOTONIC);
}

double pc_clock_cpu(void) {
    return seconds(CLOCK_PROCESS_CPUTIME_ID);
}

size_t pc_clock_peak_bytes(void) {
    struct rusage usage;
    (void)getrusage(RUSAGE_SELF, &usage);
    return (size_t)usage.ru_maxrss * 1024;
}

void pc_clock_reset_peak(void) {
    int file = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
    if (file < 0) return;
    (void)!write(file, "5", 1); /* proc(5): resets the peak resident set */
    (void)close(file);
}
