/* The products of the stages that are in memory. Each stage fills and frees its own part. */
#ifndef PC_HELD_H
#define PC_HELD_H

#include "adapt.h"
#include "curvature.h"
#include "field.h"
#include "layout.h"
#include "order.h"
#include "param.h"
#include "parts.h"
#include "polymesh.h"
#include "remesh.h"

/* The scan as the user gave it, triangulated and repaired, in the user's order. */
typedef struct pc_held_scan {
    pc_mesh mesh;
    pc_index *vertex_source; /* per vertex: the vertex of the file */
    pc_index *face_source;   /* per face: the triangle of the file, polygons cut into triangles in place */
} pc_held_scan;

/* The scan with long edges split, in an order that keeps neighbours close. The user's order has the vertices
 * of the scan first, then those added; parts of one scan face follow each other. */
typedef struct pc_held_mesh {
    pc_mesh mesh;
    pc_adjacency adjacency; /* made again when loaded */
    pc_order order;         /* old: the user's order, new: that of `mesh` */
    pc_index loop_count;
    pc_index *loop_new;  /* per boundary loop in the user's order: its place among those of `mesh` */
    pc_index *loop_old;  /* the inverse */
    pc_index *scan_face; /* per face in the user's order: the face of the scan it is a part of */
    pc_index *parent;    /* 2 per added vertex: the earlier vertices it stands between, in the user's order */
    pc_index scan_vertex_count;
    double area;      /* model units squared */
    double mean_edge; /* of the scan, model units */
    double period;    /* the side of a cell to start from, model units */
} pc_held_mesh;

/* The spline and how far it got. */
typedef struct pc_held_spline {
    pc_tspline surface;
    pc_adapt_stats stats;
    pc_basis_facts facts;
    double tolerance;     /* model units */
    double diagonal;      /* of the scan's box */
    double earlier_error; /* that of another try, see pc_convert; 0: there was none */
} pc_held_spline;

typedef struct pc_held {
    pc_held_scan scan;
    pc_held_mesh mesh;
    pc_parts parts;
    pc_curvature curvature;
    pc_field field;
    double *scale; /* per vertex: the curl correction, in (0,1] */
    pc_param param;
    pc_layout layout;
    pc_layout_stats layout_stats; /* when it was made in this run */
    pc_polymesh quads;
    pc_remesh_quads_stats quads_stats; /* when they were made in this run */
    pc_held_spline spline;
} pc_held;

#endif
