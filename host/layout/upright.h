/* Sets up the last quads that face against the scan: searches a better place for their vertices one by one.
 */
#ifndef PC_UPRIGHT_H
#define PC_UPRIGHT_H

#include "ground.h"
#include "polymesh.h"

typedef struct pc_upright_options {
    int bent_rounds; /* before: for faces with a corner that turns the wrong way */
    int rounds;   /* over the vertices of such faces, and from round to round of those farther around them */
    double reach; /* how far off the scan a vertex may end, in mean edge lengths around it; only where no
                     place on the scan does */
} pc_upright_options;
#define PC_UPRIGHT_DEFAULTS                                                                                  \
    { 4, 10, 0.3 }

/* What a face is judged by. The normals are the scan's at the closest points, whatever sheet they are on:
 * that is what anybody can check afterwards. */
typedef struct pc_stance {
    double smooth;  /* cosine between the normal of the face and the sum of the scan's smooth normals at its
                       corners and centre */
    double corners; /* ... at its corners alone */
    double
        centre; /* ... at its centre alone; or the normals of the scan's triangles there, whichever is less */
    double area; /* over the square of its mean side */
    double sine; /* the smallest of the corners that are not flat, about the sum of those normals */
} pc_stance;

/* Judges a face from its positions alone. */
pc_stance pc_upright_judge(const pc_ground *ground, const pc_polymesh *quads, pc_index face);
/* Whether anybody may call a face upside down or without area. */
bool pc_upright_is_folded(const pc_stance *stance);

/* What one call knows at its end. */
typedef struct pc_upright_memory pc_upright_memory;
void pc_upright_memory_free(pc_upright_memory *memory, pc_context *ctx);

/* Moves vertices along the scan, border vertices along its border, as long as the sum of penalties of the
 * faces around gets smaller; a vertex whose faces are all in order only for the sake of others. `folded` (per
 * face) tells the faces that are upside down before, and gets 1 where one still is; `*left` counts. Same
 * result for any number of threads. `memory` (or NULL) makes later calls on the same ground faster where most
 * of the mesh is as an earlier one left it, and changes nothing else: *memory is NULL before the first call,
 * and freed by the caller. */
pc_status pc_upright_make(pc_polymesh *quads, uint8_t *folded, pc_index *left, pc_upright_memory **memory,
                          pc_context *ctx, const pc_ground *ground, const pc_upright_options *options);

#endif
