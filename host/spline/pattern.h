/* Polygons to faces of four corners with T-junctions in their sides (digest C33). */
#ifndef PC_PATTERN_H
#define PC_PATTERN_H

#include "polymesh.h"

typedef struct pc_pattern {
    pc_polymesh faces;  /* four corners each that are not flat; vertices of the polygons come first */
    pc_index *source;   /* per face: the polygon that it is, or is a part of */
    uint8_t *whole;     /* per face: 1 where it is one with T-junctions that the polygons had */
    double *interval;   /* per corner: 1, and 1/2 on both parts of edges cut in half and around the centres of
                           odd patterns; faces that are not `whole` agree with that */
    pc_index pairs;     /* of polygons with an odd number of corners that became one polygon */
    pc_index cuts;      /* edges that join two vertices of a polygon */
    pc_index even, odd; /* polygons, or parts of them, divided around a centre */
} pc_pattern;

/* Polygons of four corners stay, with their T-junctions, but for those with apart[f] != 0 (NULL: none). All
 * others are taken apart, T-junctions being corners like others:
 * - more than five corners: cut from corner to corner, where that makes better valences than a centre;
 * - an even number: a centre joined to every second corner, to those of valence 3 rather than others;
 * - an odd number: a centre joined to the middle of every side. Neighbours get T-junctions there.
 * Vertices between two polygons only go. PC_E_MESH where an edge is not between two faces that run along it
 * in opposite directions, PC_E_BUG where a corner is out of range, PC_E_NOMEM. */
pc_status pc_pattern_make(pc_pattern *pattern, pc_context *ctx, const pc_polymesh *polygons,
                          const uint8_t *apart);
void pc_pattern_free(pc_pattern *pattern, pc_context *ctx);

#endif
