/* Any triangle soup becomes an oriented 2-manifold mesh, and a report says what was done. */
#ifndef PC_REPAIR_H
#define PC_REPAIR_H

#include "trimesh.h"

typedef struct pc_repair_options {
    bool strict;             /* refuse edges with more than two faces instead of cutting them */
    bool tear_nonorientable; /* tear a piece without orientation (Moebius strip) open along a seam instead of
                                refusing */
    pc_index min_component;  /* drop pieces with fewer faces than this */
    double crowded_share;    /* refuse where more than this share of the edges has more than two faces: no
                                surface */
    double shred_share;      /* refuse where more than this share of the faces is in shreds, pieces of fewer
                                than PC_REPAIR_SHRED faces: triangles that nobody joined */
} pc_repair_options;
#define PC_REPAIR_DEFAULTS                                                                                   \
    { false, false, 0, 0.05, 0.5 }
/* So many crowded edges are cut in any case, and so many shreds taken as they are. */
enum { PC_REPAIR_FEW_CROWDED = 32, PC_REPAIR_SHRED = 8, PC_REPAIR_FEW_SHREDS = 32 };

/* How often a defect occurs, and the first few places. */
enum { PC_DEFECT_IDS = 8 };
typedef struct pc_defect {
    pc_index count;
    pc_index id[PC_DEFECT_IDS]; /* min(count, PC_DEFECT_IDS) of them, numbers of the given mesh */
} pc_defect;

typedef struct pc_repair_report {
    pc_defect merged_vertices; /* vertices merged into an earlier one at exactly the same position */
    pc_defect
        isolated_vertices; /* vertices that no face used, dropped (also those used by dropped faces only) */
    pc_defect degenerate_faces; /* faces with a repeated vertex (after merging), dropped */
    pc_defect duplicate_faces;  /* faces on the same vertices as an earlier one, dropped; with both faces of a
                                   pair  that only folds back from one edge */
    pc_defect
        crowded_edges;    /* edges with more than two faces, cut into sheets; ids are half-edges 3*face+k */
    pc_defect torn_edges; /* edges torn in pieces without orientation; half-edges */
    pc_defect flipped_faces;      /* faces turned round, for one orientation per piece */
    pc_defect split_vertices;     /* bow-ties: vertices that joined several fans of faces, split */
    pc_defect cut_vertices;       /* vertices split because they lie on crowded or torn edges */
    pc_defect cut_edges;          /* edges that needed a new vertex in the middle to come apart; half-edges */
    pc_defect dropped_components; /* pieces under min_component; ids are their first faces */
    pc_defect dropped_faces;      /* their faces */
    pc_defect zero_area_faces;    /* three different, exactly collinear vertices */
    pc_index cured_zero_area; /* of those: cured by flipping their longest edge, or dropped at a boundary */
    pc_index vertex_count, face_count; /* of the result; as long are the next two */
    pc_index *vertex_source; /* per vertex of the result: the given vertex there; for a new one on an edge the
                                end of the edge that is its tail */
    pc_index *face_source;   /* per face of the result: the given face it is (a part of) */
    pc_index given_vertex_count;
    pc_index *vertex_target; /* per given vertex: the first vertex of the result there, PC_NONE if dropped */
    bool changed;            /* false: the result is the given mesh, number by number */
} pc_repair_report;

/* `in` may be any soup of triangles; `out` passes pc_mesh_check and pc_adjacency_make and has edges of
 * positive length. In order: vertices at exactly the same position are merged where they are on open or
 * crowded edges or on edges of no length (two surfaces that touch inside stay apart); faces with a repeated
 * vertex and duplicates dropped; crowded edges cut into sheets (pc_sheets_make tells how) and pieces
 * oriented; small pieces dropped; vertices split into one per fan; edges that still run between the same two
 * vertices get a new vertex in the middle; unused vertices dropped; zero-area faces cured where flipping
 * their longest edge leaves the surface as it is (else they stay: removing one would open a crack). What is
 * not defective keeps its order and place, and a clean mesh comes out as it was. The caller frees `out` and
 * `report`. PC_E_MESH, with ids and a hint: vertex index out of range, coordinate not finite, no face left, a
 * piece without orientation (unless tear_nonorientable), crowded edges with `strict` or too many of them. */
pc_status pc_repair(pc_mesh *out, pc_repair_report *report, pc_context *ctx, const pc_mesh *in,
                    const pc_repair_options *options);
/* What pc_repair demands of any soup: vertex indices in range, coordinates finite. PC_E_MESH names the first
 * offender.*/
pc_status pc_repair_check_input(pc_context *ctx, const pc_mesh *in);
void pc_repair_report_free(pc_repair_report *report, pc_context *ctx);

static inline void pc_defect_note(pc_defect *defect, pc_index id) {
    if (defect->count < PC_DEFECT_IDS) defect->id[defect->count] = id;
    defect->count++;
}

#endif
