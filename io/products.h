/* The products of the stages in a store. `group` is where the arrays go, by convention the stage's name
 * ("mesh", "field", "param", "layout", "quads"); docs/file-format.md lists them. What is saved is loaded bit
 * for bit.
 *
 * _save: PC_E_IO, PC_E_NOMEM. _load: the product is the caller's to free; PC_E_FORMAT, with nothing to free,
 * where an array is missing, of another type or size, or where an index points past its array. */
#ifndef PC_PRODUCTS_H
#define PC_PRODUCTS_H

#include "curvature.h"
#include "field.h"
#include "layout.h"
#include "param.h"
#include "polymesh.h"
#include "store.h"
#include "trimesh.h"

pc_status pc_mesh_save(pc_store *store, const char *group, const pc_mesh *mesh);
pc_status pc_mesh_load(pc_mesh *mesh, pc_store *store, const char *group);

pc_status pc_curvature_save(pc_store *store, const char *group, const pc_curvature *curvature);
pc_status pc_curvature_load(pc_curvature *curvature, pc_store *store, const char *group);

pc_status pc_field_save(pc_store *store, const char *group, const pc_field *field);
pc_status pc_field_load(pc_field *field, pc_store *store, const char *group);

pc_status pc_param_save(pc_store *store, const char *group, const pc_param *param);
pc_status pc_param_load(pc_param *param, pc_store *store, const char *group);

pc_status pc_layout_save(pc_store *store, const char *group, const pc_layout *layout);
pc_status pc_layout_load(pc_layout *layout, pc_store *store, const char *group);

pc_status pc_polymesh_save(pc_store *store, const char *group, const pc_polymesh *mesh);
pc_status pc_polymesh_load(pc_polymesh *mesh, pc_store *store, const char *group);

/* One list of indices (maps, orders, parts) or of doubles (scale per vertex), `count` long. `name` is the
 * full path. On loading `*count` is the length demanded, PC_STORE_ANY for any. */
pc_status pc_indices_save(pc_store *store, const char *name, const pc_index *list, size_t count,
                          const char *description);
pc_status pc_indices_load(pc_index **list, size_t *count, pc_store *store, const char *name);
pc_status pc_reals_save(pc_store *store, const char *name, const double *list, size_t count,
                        const char *units, const char *description);
pc_status pc_reals_load(double **list, size_t *count, pc_store *store, const char *name);

#endif
