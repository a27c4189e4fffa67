#include "version.h"

const char *pc_version(void) {
    return PERCALE_VERSION;
}
