/* The blending functions of a T-mesh, cut into bicubic elements (Bezier extraction: Scott et al. 2011): all
 * that evaluation, fitting, refinement and export need. */
#ifndef PC_BASIS_H
#define PC_BASIS_H

#include "tmesh.h"

/* A rectangle of parameters within a face on which the surface is one bicubic polynomial. */
typedef struct pc_element {
    pc_index face;
    bool irregular;         /* its face has an extraordinary corner */
    double low[2], high[2]; /* in the frame of the face */
    size_t coefficient;     /* where its coefficients start */
} pc_element;

typedef struct pc_basis {
    pc_index vertex_count, face_count, element_count;
    pc_index *face_start; /* face_count+1 offsets into element; ghosts have none */
    pc_element *element;
    size_t *start;       /* element_count+1 offsets into point */
    pc_index *point;     /* the vertices whose functions are not zero on the element */
    double *coefficient; /* per point: of a regular element 4 in s and 4 in t, whose products are the Bezier
                            coefficients; of an irregular one all 16 (i + 4j) */
} pc_basis;

pc_status pc_basis_make(pc_basis *basis, pc_context *ctx, const pc_tmesh *mesh);
void pc_basis_free(pc_basis *basis, pc_context *ctx);

/* What a basis must be: on every element the functions sum to one, and are not negative where they are
 * products of B-splines; and linearly independent, shown element by element (regular ones have exactly 16
 * functions, whose 16 x 16 coefficients have full rank) and for the rest face by face. */
typedef struct pc_basis_facts {
    double worst_sum;         /* largest |sum - 1| over all Bezier coefficients */
    double least_pivot;       /* of the elimination, relative to the largest of its element */
    pc_index most_points;     /* functions on one regular element */
    pc_index unused_vertices; /* no function of theirs on the surface: outer corners of ghosts */
} pc_basis_facts;
/* PC_E_BUG where they are not; PC_E_MESH where the functions that live on irregular faces only are dependent,
 * as on the cube of eight vertices, where Catmull and Clark's rules take +1 and -1 in turn to zero. `facts`
 * may be NULL. */
pc_status pc_basis_check(const pc_basis *basis, pc_basis_facts *facts, pc_context *ctx);

/* The 16 Bezier coefficients of point k (an index into basis->point) on element e. */
void pc_basis_coefficients(double c[16], const pc_basis *basis, pc_index e, size_t k);
/* The Bezier points of element e: 16 x 3, i + 4j, i along s. `position` has 3 per vertex. */
void pc_basis_bezier(double bezier[48], const pc_basis *basis, pc_index e, const double *position);
/* The element of a face that holds the parameters; those outside go to the nearest. PC_NONE for ghosts. */
pc_index pc_basis_find(const pc_basis *basis, pc_index face, double s, double t);

#endif
