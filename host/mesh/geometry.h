/* Lengths, angles, areas and normals of a triangle mesh. Nothing here makes a NaN, also not from zero-area
 * faces. */
#ifndef PC_GEOMETRY_H
#define PC_GEOMETRY_H

#include "adjacency.h"
#include "vec3.h"

typedef struct pc_box {
    pc_vec3 low, high;
} pc_box;

/* How values spread: the quantiles are values of the sample itself (nearest rank). All 0 for an empty sample.
 */
typedef struct pc_spread {
    size_t count;
    double min, q01, q05, q25, median, q75, q95, q99, max, mean;
} pc_spread;

typedef enum pc_normal_weight { PC_NORMAL_ANGLE, PC_NORMAL_AREA } pc_normal_weight;

/* Cotangents are clamped to this size: an angle of 1e-6 rad. */
#define PC_COTANGENT_LIMIT 1e6

/* The angle between two vectors in 0..pi; pi/2 where one of them is zero. */
double pc_angle(pc_vec3 u, pc_vec3 v);
/* Its cotangent, clamped to PC_COTANGENT_LIMIT; 0 where one of them is zero. */
double pc_cotangent(pc_vec3 u, pc_vec3 v);
/* Unit normal of the triangle a b c, counter-clockwise; zero where the area is zero. No over- or underflow.
 */
pc_vec3 pc_triangle_normal(pc_vec3 a, pc_vec3 b, pc_vec3 c);
double pc_triangle_area(pc_vec3 a, pc_vec3 b, pc_vec3 c);
/* The angle of the face of half-edge h at the tail of h. */
double pc_corner_angle(const pc_mesh *mesh, pc_index h);
/* The three angles, which sum to pi: also of collinear (0, 0, pi) and of coincident corners. */
void pc_triangle_angles(double angle[3], pc_vec3 a, pc_vec3 b, pc_vec3 c);

/* Of the vertices that are there, used or not; an empty mesh gives a box of zeros. */
pc_box pc_geometry_box(const pc_mesh *mesh);
/* Of `count` points, 3 each. */
pc_box pc_box_of(const double *position, size_t count);
double pc_box_diagonal(pc_box box);
/* Sum of the face areas, in the user's units squared. */
double pc_geometry_area(const pc_mesh *mesh);
/* Six times the volume is the sum of the determinants; positive where closed and oriented outward. */
double pc_geometry_volume(const pc_mesh *mesh);
/* Mean length over the edges, each once. 0 without edges. */
double pc_geometry_mean_edge(const pc_mesh *mesh, const pc_adjacency *adjacency);

/* One value per vertex: a third of the area of its faces, and at least `least_share` of the mean, so that
 * systems with these on the diagonal stay definite where faces have no area. 1 where no face has one. */
void pc_geometry_vertex_areas(double *area, const pc_mesh *mesh, double least_share);
/* One value per edge / per corner 3f+k (angle at corner k). */
void pc_geometry_edge_lengths(double *length, const pc_mesh *mesh, const pc_adjacency *adjacency);
void pc_geometry_corner_angles(double *angle, const pc_mesh *mesh);
/* Per half-edge h: the cotangent of the angle opposite to it in its face, clamped. */
void pc_geometry_cotangents(double *cotangent, const pc_mesh *mesh);
/* 3 per vertex, always unit length: the weighted mean of the faces' normals; where that vanishes the normal
 * of the largest face around, and the z axis where no face there has an area. */
void pc_geometry_vertex_normals(double *normal, const pc_mesh *mesh, const pc_adjacency *adjacency,
                                pc_normal_weight weight);

/* The spread of `count` finite values, which end up reordered. Linear time. */
pc_spread pc_spread_of(double *value, size_t count);

#endif
