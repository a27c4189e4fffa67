/* Between the order in which Percale computes and the order of the user's scan: files hold the latter. */
#ifndef PC_USER_ORDER_H
#define PC_USER_ORDER_H

#include "held.h"

/* A renumbering: what stands at place i of the new order is at vertex[i], face[i], loop[i] of the old one.
 * Faces keep the order of their corners. */
typedef struct pc_renumbering {
    pc_index vertex_count, face_count, loop_count;
    const pc_index *vertex, *face, *loop;
    const pc_index *vertex_place; /* the inverse of `vertex` */
    const pc_index *face_place;
} pc_renumbering;

pc_renumbering pc_to_user_order(const pc_held_mesh *mesh);
pc_renumbering pc_from_user_order(const pc_held_mesh *mesh);

/* Each gives a copy in the new order, which the caller frees. PC_E_NOMEM. */
pc_status pc_renumber_mesh(pc_mesh *out, pc_context *ctx, const pc_mesh *in, const pc_renumbering *r);
pc_status pc_renumber_curvature(pc_curvature *out, pc_context *ctx, const pc_curvature *in,
                                const pc_renumbering *r);
pc_status pc_renumber_field(pc_field *out, pc_context *ctx, const pc_field *in, const pc_renumbering *r);
pc_status pc_renumber_param(pc_param *out, pc_context *ctx, const pc_param *in, const pc_renumbering *r);
/* The vertices and faces that a layout adds to the mesh keep their order. */
pc_status pc_renumber_layout(pc_layout *out, pc_context *ctx, const pc_layout *in, const pc_renumbering *r);
/* out[i] = in[vertex[i]] */
pc_status pc_renumber_reals(double **out, pc_context *ctx, const double *in, const pc_renumbering *r);
pc_status pc_renumber_indices(pc_index **out, pc_context *ctx, const pc_index *in, const pc_renumbering *r);

#endif
