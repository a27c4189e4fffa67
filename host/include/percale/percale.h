/* Everything that Percale offers, for C and C++. */
#ifndef PERCALE_H
#define PERCALE_H

/* Named here so that C++ reads them outside the block below. */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "run.h"

#ifdef __cplusplus
}
#endif

#endif
