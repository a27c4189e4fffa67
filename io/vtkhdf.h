/* Meshes with their fields for VTK and ParaView: VTKHDF, UnstructuredGrid, version 1.0, which ParaView 5.10
 * and VTK 9.1 and everything since read. The usual ending is .hdf. The files are stores (store.h): whole or
 * absent, and equal for equal calls. All functions: PC_E_IO, PC_E_NOMEM. */
#ifndef PC_VTKHDF_H
#define PC_VTKHDF_H

#include "curvature.h"
#include "field.h"
#include "layout.h"
#include "param.h"
#include "polymesh.h"
#include "skin.h"
#include "store.h"

/* One array for the points or the cells of a grid. */
typedef struct pc_vtk_array {
    const char *name;
    pc_store_type type;
    int components; /* numbers per point or cell, together in memory */
    bool on_cells;
    const void *data;
    const char *units, *description;
} pc_vtk_array;

/* Triangles with any arrays. `options` may be NULL. */
pc_status pc_vtkhdf_write_triangles(pc_context *ctx, const char *path, const pc_mesh *mesh,
                                    const pc_vtk_array *arrays, size_t array_count,
                                    const pc_store_options *options);
/* Polygons: VTK_TRIANGLE, VTK_QUAD or VTK_POLYGON by their number of corners, T-junctions counted. Cell data
 * `sides`: corners that are not T-junctions. */
pc_status pc_vtkhdf_write_polygons(pc_context *ctx, const char *path, const pc_polymesh *mesh,
                                   const pc_vtk_array *arrays, size_t array_count,
                                   const pc_store_options *options);
/* The scan with what is known on it; each of `curvature`, `field` and `param` may be NULL. Point data: k1,
 * k2, curvature_direction, curvature_weight; normal, direction; s, t (periods). Cell data: singularity (N
 * times the index), singular (enum of param.h). */
pc_status pc_vtkhdf_write_scan(pc_context *ctx, const char *path, const pc_mesh *mesh,
                               const pc_curvature *curvature, const pc_field *field, const pc_param *param,
                               const pc_store_options *options);
/* The refined scan with the cell and the scan triangle in which each of its triangles lies (cell,
 * source_face). */
pc_status pc_vtkhdf_write_layout(pc_context *ctx, const char *path, const pc_layout *layout,
                                 const pc_store_options *options);

/* The spline surface as triangles. `distance`, per vertex of the skin to the scan, may be NULL. Point data:
 * normal, distance. Cell data: element, face (of the T-mesh). */
pc_status pc_vtkhdf_write_surface(pc_context *ctx, const char *path, const pc_tspline *spline,
                                  const pc_skin *skin, const double *distance,
                                  const pc_store_options *options);

#endif
