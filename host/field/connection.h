/* A discrete connection: tangent frames at the vertices and the turn of the frame along each edge. */
#ifndef PC_CONNECTION_H
#define PC_CONNECTION_H

#include "adjacency.h"

typedef struct pc_connection {
    pc_index vertex_count;
    double *normal; /* 3 per vertex, unit: area-weighted mean of the faces' normals */
    double *axis;   /* 3 per vertex, unit tangent: the direction of angle 0; angle pi/2 is normal x axis */
    double
        *total; /* per vertex: the sum of its corner angles; 2 pi inside, the interior angle on a boundary */
    double *angle;     /* per half-edge: its direction in the frame of its tail, in [0, total) */
    double *transport; /* per half-edge i->j: a tangent vector of angle x at i arrives at j with angle
                          x+transport. The opposite half-edge has the opposite sign */
    double *weight;    /* per edge: half the sum of the two cotangents, made safe */
} pc_connection;

/* Corner angles at an inner vertex are scaled to add up to 2 pi (Polthier and Schmies 1998; Knoeppel et al.
 * 2013); at a boundary vertex they stay, the rest belongs to the hole. `axis` is the tangent direction that
 * fits the projected edges best, so that noise in one edge does not turn the frame. Weights: each cotangent
 * is clamped to [-PC_COTANGENT_MOST, PC_COTANGENT_MOST], their half sum raised to at least PC_WEIGHT_LEAST.
 * That keeps every weight positive without the flips of an intrinsic Delaunay triangulation: smooth fields
 * differ by little, and zero-area triangles do no harm. PC_E_NOMEM. */
#define PC_COTANGENT_MOST 10.0
#define PC_WEIGHT_LEAST   0.05
pc_status pc_connection_make(pc_connection *connection, pc_context *ctx, const pc_mesh *mesh,
                             const pc_adjacency *adjacency);
void pc_connection_free(pc_connection *connection, pc_context *ctx);
/* The scaled angle of the corner at the tail of half-edge h. */
double pc_connection_corner(const pc_connection *connection, const pc_mesh *mesh,
                            const pc_adjacency *adjacency, pc_index h);
/* The angle of a 3D vector, projected on the tangent plane, in the frame of v; and back to a unit vector. */
double pc_connection_angle(const pc_connection *connection, pc_index v, const double vector[3]);
void pc_connection_direction(double vector[3], const pc_connection *connection, pc_index v, double angle);

#endif
