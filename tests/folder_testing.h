/* A new folder to work in, for groups of tests that leave it empty. */
#ifndef PC_FOLDER_TESTING_H
#define PC_FOLDER_TESTING_H

#include "testing.h"
#include <stdlib.h>
#include <unistd.h>

static char test_folder[64];

static inline int enter_folder(void **state) {
    (void)state;
    (void)snprintf(test_folder, sizeof test_folder, "/tmp/percale-test-XXXXXX");
    return mkdtemp(test_folder) && chdir(test_folder) == 0 ? 0 : -1;
}

static inline int leave_folder(void **state) {
    (void)state;
    return chdir("/") == 0 && rmdir(test_folder) == 0 ? 0 : -1;
}

#endif
