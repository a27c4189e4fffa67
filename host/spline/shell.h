/* A spline surface as faces, edges and vertices with exact geometry, for CAD files: every edge is shared by
 * the faces beside it, every curve is the boundary of their surfaces. Bicubic B-splines throughout, no
 * approximation anywhere. */
#ifndef PC_SHELL_H
#define PC_SHELL_H

#include "blocks.h"

/* A clamped cubic B-spline curve: simple knots inside, fourfold at the ends; point_count-2 distinct ones. */
typedef struct pc_shell_edge {
    pc_index vertex[2];
    pc_index point_count;
    size_t point; /* the first in pc_shell.point, 3 each */
    size_t knot;  /* the first in pc_shell.knot */
} pc_shell_edge;

/* A clamped bicubic B-spline surface bounded by all of its sides. The normal S_s x S_t points outward. */
typedef struct pc_shell_face {
    pc_index point_count[2]; /* s runs fastest */
    size_t point;
    size_t knot[2];
    size_t loop; /* the first in pc_shell.loop: 2*edge, +1 where it is run backwards; counter-clockwise */
    pc_index loop_count;
    pc_index component; /* pieces of surface that hang together across edges */
} pc_shell_face;

typedef struct pc_shell {
    pc_index vertex_count, edge_count, face_count, component_count;
    pc_index border_count; /* edges of one face only: 0 for a closed surface */
    double *vertex;        /* 3 each */
    pc_shell_edge *edge;
    pc_shell_face *face;
    pc_index *loop;
    double *point;
    double *knot;
    size_t vertex_room, edge_room, face_room, loop_room, point_room, knot_room;
    size_t loop_count, point_count, knot_count;
} pc_shell;

/* Blocks of regular faces become one face each, around extraordinary vertices every element. PC_E_NOMEM. */
pc_status pc_shell_make(pc_shell *shell, pc_context *ctx, const pc_tspline *spline);
void pc_shell_free(pc_shell *shell, pc_context *ctx);
/* Every loop closes, every edge is used once in each direction (or once in all, on a border), curves begin
 * and end at their vertices, and lie on the sides of their faces up to 1e-12 of `size`. PC_E_BUG else. */
pc_status pc_shell_check(const pc_shell *shell, pc_context *ctx, double size);

/* The point of edge e at parameter u in 0..1 of its whole, and of face f at (s,t) in 0..1 each. */
pc_vec3 pc_shell_edge_point(const pc_shell *shell, pc_index e, double u);
pc_vec3 pc_shell_face_point(const pc_shell *shell, pc_index f, double s, double t);

#endif
