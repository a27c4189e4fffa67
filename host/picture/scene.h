/* What Percale shows of its work: each call draws one product into a picture.
 * A picture of the field:
 *   pc_picture_make(&picture, ctx, mesh->position, mesh->vertex_count, &options);
 *   pc_scene_scan(&picture, ctx, mesh);
 *   pc_scene_field(&picture, ctx, mesh, field);
 *   pc_picture_pixels(&pixels, ctx, &picture);   then pc_png_save
 * All calls: PC_E_NOMEM; meshes may hold faces without area or points that are not finite (not drawn). */
#ifndef PC_SCENE_H
#define PC_SCENE_H

#include "colormap.h"
#include "field.h"
#include "layout.h"
#include "param.h"
#include "picture.h"
#include "polymesh.h"
#include "trimesh.h"

/* The scan in a light clay. */
pc_status pc_scene_scan(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh);

/* The directions, evenly spread: arrows (N = 1), lines (2), crosses (4) in the tangent plane; singularities
 * as balls, blue below zero and red above, larger where |index| > 1/N. Draw the scan first. */
pc_status pc_scene_field(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh, const pc_field *field);

/* One number per vertex as colours with a legend (numbers in the caller's unit). low == high: a robust range
 * is taken, symmetric to 0 up to the 95 % quantile of |value| for a diverging map, 0..99 % for the other. */
pc_status pc_scene_values(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh, const double *value,
                          const pc_colormap *map, double low, double high, const char *title);

/* Lines at whole (bold) and half (thin) periods of s and t; singular triangles tinted. Draws the scan too. */
pc_status pc_scene_param(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh, const pc_param *param);

/* The quads: edges, faces other than quads tinted by their sides (T-junctions on straight sides do not
 * count), balls at interior vertices of other valence than 4 (3 red, 5 blue, more violet, less orange), small
 * orange ones at T-junctions. */
pc_status pc_scene_quads(pc_picture *picture, pc_context *ctx, const pc_polymesh *quads);

/* The cells in soft colours of their own, the arcs between them, the nodes. */
pc_status pc_scene_layout(pc_picture *picture, pc_context *ctx, const pc_layout *layout);

/* One line of text in the lower left corner. */
pc_status pc_scene_caption(pc_picture *picture, pc_context *ctx, const char *text);

#endif
