/* The figures of a quad mesh beside the scan it was made of. */
#ifndef PC_QUALITY_H
#define PC_QUALITY_H

#include "cellshape.h"
#include "deviation.h"
#include "field.h"
#include "polygraph.h"
#include "polymesh.h"

/* The last one counts all larger ones. */
enum { PC_QUALITY_SIDES = 9 };

typedef struct pc_quality {
    pc_surface_count scan, quads;

    /* Counts. A corner that is a T-junction on a straight side is a corner of the polygon, not of the cell.
     */
    pc_index polygons[PC_QUALITY_SIDES]; /* faces by number of corners */
    pc_index cells[PC_QUALITY_SIDES];    /* faces by number of corners without the flat ones */
    double quad_polygon_percent;         /* polygons with exactly four corners */
    double quad_cell_percent;            /* faces with four corners that are not flat */
    pc_index t_junctions;                /* vertices that are flat in some face */
    pc_index boundary_vertices, interior_vertices;
    pc_index irregular_interior; /* sides plus flat corners are not 4 */
    pc_index irregular_boundary; /* sides plus flat corners are neither 2 nor 3 */

    pc_cellshape shape;
    pc_spread field_angle; /* degrees between an edge and the nearest direction of the field (0..45) */

    /* Distance, model units, beside the diagonal of the scan's bounding box. */
    double diagonal;
    pc_deviation scan_to_quads, quads_to_scan;
    double scan_area, quads_area;
    double
        worst_component; /* the largest distance to the quads from that scan component that is served worst */
    pc_index worst_component_id;
    pc_index missed_components; /* scan components that no face is nearest to */

    /* Broken cells, with the first of each kind. */
    pc_index inverted, first_inverted;   /* normal against the scan's smooth normals at corners and centre */
    pc_index zero_area, first_zero_area; /* area under 1e-12 of the mean */
    pc_index wild_vertices;              /* a coordinate that is not finite */
} pc_quality;

typedef struct pc_quality_input {
    const pc_mesh *scan;      /* as converted: manifold */
    const pc_polymesh *quads; /* may be broken in any way but indices out of range */
    const pc_field *field;    /* on the scan; may be NULL: no field_angle */
    const pc_bvh *scan_tree;  /* over the scan; NULL: made here */
} pc_quality_input;

/* Time: a few microseconds per vertex of both and per sample. The same figures for any number of threads.
 * PC_E_BUG where indices are out of range, PC_E_NOMEM, PC_E_INTERRUPT. */
pc_status pc_quality_measure(pc_quality *quality, pc_context *ctx, const pc_quality_input *input);

#endif
