/* The curvature in a store, as io/products.h does it for the other products. */
#ifndef PC_CURVATURE_STORE_H
#define PC_CURVATURE_STORE_H

#include "curvature.h"
#include "store.h"

pc_status pc_curvature_save(pc_store *store, const char *group, const pc_curvature *curvature);
pc_status pc_curvature_load(pc_curvature *curvature, pc_store *store, const char *group);

#endif
