/* Everything that Percale offers, for C and C++. */
#ifndef PERCALE_H
#define PERCALE_H

/* Named here so that C++ reads them outside the block below. */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "adapt.h"
#include "bext.h"
#include "cage.h"
#include "certificate.h"
#include "continuity.h"
#include "curl.h"
#include "curvature.h"
#include "device.h"
#include "differential.h"
#include "field.h"
#include "geometry.h"
#include "gismo.h"
#include "iga.h"
#include "iges.h"
#include "insertion.h"
#include "inspect.h"
#include "layout.h"
#include "measure.h"
#include "memory.h"
#include "nearest.h"
#include "order.h"
#include "param.h"
#include "parts.h"
#include "png_file.h"
#include "polyfile.h"
#include "products.h"
#include "quads.h"
#include "quality.h"
#include "refine.h"
#include "repair.h"
#include "run.h"
#include "scan.h"
#include "scene.h"
#include "scene_spline.h"
#include "shell.h"
#include "spline_store.h"
#include "step.h"
#include "store.h"
#include "topology.h"
#include "tspline.h"
#include "version.h"
#include "vtkhdf.h"

#ifdef __cplusplus
}
#endif

#endif
