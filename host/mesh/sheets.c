#include "sheets.h"
#include "geometry.h"
#include "halfsort.h"
#include "memory.h"
#include <stdlib.h>

/* Patches are what edges with exactly two faces join; a tree of them with the parity of each against its
 * parent. */
typedef struct patch_forest {
    pc_index *parent;
    uint8_t *parity;
} patch_forest;

typedef struct work {
    const pc_mesh *mesh;
    pc_halfsort sorted;
    pc_index *patch;   /* per face */
    uint8_t *turned;   /* per face: against most of its patch */
    uint8_t *single;   /* per half-edge: alone on its edge */
    pc_index *crowded; /* pairs: begin and end in sorted.half */
    patch_forest forest;
} work;

static pc_index find_root(const patch_forest *forest, pc_index patch, uint8_t *parity) {
    *parity = 0;
    while (forest->parent[patch] != patch) {
        *parity ^= forest->parity[patch];
        patch = forest->parent[patch];
    }
    return patch;
}

/* Afterwards, roots are the smaller patches, and all entries on the way point at them. */
static void unite(patch_forest *forest, pc_index a, pc_index b, uint8_t parity) {
    pc_index low = a < b ? a : b, high = a < b ? b : a;
    forest->parent[high] = low;
    forest->parity[high] = parity;
}

static void shorten_path(patch_forest *forest, pc_index patch) {
    uint8_t parity;
    pc_index root = find_root(forest, patch, &parity);
    while (forest->parent[patch] != patch) {
        pc_index above = forest->parent[patch];
        uint8_t step = forest->parity[patch];
        forest->parent[patch] = root;
        forest->parity[patch] = parity;
        parity ^= step;
        patch = above;
    }
}

static bool same_direction(const pc_mesh *mesh, pc_index h, pc_index g) {
    return pc_tail(mesh, h) == pc_tail(mesh, g);
}

static void mark_ends(pc_sheets *sheets, const pc_mesh *mesh, pc_index h) {
    sheets->vertex_cut[pc_tail(mesh, h)] = sheets->vertex_cut[pc_head(mesh, h)] = 1;
}

static pc_index count_crowded(const work *w) {
    pc_index count = 0;
    for (pc_index v = 0; v < w->mesh->vertex_count; v++)
        for (pc_index i = w->sorted.start[v], end = w->sorted.start[v + 1], next; i < end; i = next) {
            next = pc_run_end(&w->sorted, w->mesh, i, end);
            count += next - i > 2;
        }
    return count;
}

static void glue_pairs(pc_sheets *sheets, work *w) {
    const pc_index *half = w->sorted.half;
    for (pc_index v = 0; v < w->mesh->vertex_count; v++)
        for (pc_index i = w->sorted.start[v], end = w->sorted.start[v + 1], next; i < end; i = next) {
            next = pc_run_end(&w->sorted, w->mesh, i, end);
            sheets->edge_count++;
            if (next - i == 1) {
                w->single[half[i]] = 1;
            } else if (next - i == 2) {
                sheets->twin[half[i]] = half[i + 1];
                sheets->twin[half[i + 1]] = half[i];
            } else {
                pc_index c = sheets->crowded_count++;
                w->crowded[2 * c] = i, w->crowded[2 * c + 1] = next;
                sheets->crowded[c] = half[i];
                mark_ends(sheets, w->mesh, half[i]);
            }
        }
}

/* Turned faces of a patch are the fewer ones. */
static void keep_majority(work *w, const pc_index *face, pc_index count) {
    pc_index turned = 0;
    for (pc_index i = 0; i < count; i++)
        turned += w->turned[face[i]];
    for (pc_index i = 0; turned > count - turned && i < count; i++)
        w->turned[face[i]] ^= 1;
}

/* Breadth first, so that where a piece has no orientation it is torn along a short seam. Returns the patches.
 */
static pc_index orient_patches(pc_sheets *sheets, work *w, pc_index *queue) {
    pc_index count = 0;
    for (pc_index f = 0; f < w->mesh->face_count; f++)
        w->patch[f] = PC_NONE;
    for (pc_index first = 0; first < w->mesh->face_count; first++) {
        pc_index read = 0, filled = 0;
        if (w->patch[first] != PC_NONE) continue;
        w->patch[first] = count;
        queue[filled++] = first;
        while (read < filled) {
            pc_index f = queue[read++];
            for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
                pc_index g = sheets->twin[h];
                if (g == PC_NONE) continue;
                uint8_t turned = w->turned[f] ^ (uint8_t)same_direction(w->mesh, h, g);
                if (w->patch[g / 3] == PC_NONE) {
                    w->patch[g / 3] = count;
                    w->turned[g / 3] = turned;
                    queue[filled++] = g / 3;
                } else if (w->turned[g / 3] != turned) {
                    sheets->twin[h] = sheets->twin[g] = PC_NONE;
                    sheets->torn_count++;
                }
            }
        }
        keep_majority(w, queue, filled);
        count++;
    }
    return count;
}

typedef struct candidate {
    int rank;    /* smaller is better: hanging faces, then kept orientation */
    int bend;    /* from straight on, in millionths of a radian */
    int concave; /* seen from outside */
    pc_index h, g;
} candidate;

static int compare_candidates(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->rank != y->rank) return x->rank < y->rank ? -1 : 1;
    if (x->bend != y->bend) return x->bend < y->bend ? -1 : 1;
    if (x->concave != y->concave) return x->concave < y->concave ? -1 : 1;
    if (x->h != y->h) return x->h < y->h ? -1 : 1;
    return x->g < y->g ? -1 : x->g > y->g;
}

/* From the edge into the face, across the edge. */
static pc_vec3 into_face(const pc_mesh *mesh, pc_index h) {
    pc_vec3 a = pc_vec3_at(mesh->position, pc_tail(mesh, h)),
            b = pc_vec3_at(mesh->position, pc_head(mesh, h));
    pc_vec3 c = pc_vec3_at(mesh->position, pc_tail(mesh, pc_prev(h))), axis = pc_unit(pc_sub(b, a));
    pc_vec3 apex = pc_sub(c, a);
    return pc_madd(apex, -pc_dot(apex, axis), axis);
}

static pc_vec3 face_normal(const pc_mesh *mesh, pc_index f) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    return pc_triangle_normal(pc_vec3_at(mesh->position, t[0]), pc_vec3_at(mesh->position, t[1]),
                              pc_vec3_at(mesh->position, t[2]));
}

static bool hangs(const work *w, pc_index h) {
    return w->single[pc_next(h)] && w->single[pc_prev(h)];
}

/* 1 where the two faces, glued here, need a turn against each other beyond what their patches have. */
static uint8_t needed_turn(const work *w, pc_index h, pc_index g) {
    return (uint8_t)same_direction(w->mesh, h, g) ^ w->turned[h / 3] ^ w->turned[g / 3];
}

static candidate rate_pair(const work *w, pc_index h, pc_index g) {
    pc_vec3 across_h = into_face(w->mesh, h), across_g = into_face(w->mesh, g);
    double above = pc_dot(face_normal(w->mesh, h / 3), across_g);
    int rank = 2 * (hangs(w, h) + hangs(w, g)) + needed_turn(w, h, g);
    int bend = (int)(1e6 * (PC_PI - pc_angle(across_h, across_g)) + 0.5);
    return (candidate){rank, bend, w->turned[h / 3] ? above < 0 : above > 0, h, g};
}

/* Glues what may be glued of one crowded edge, best pairs first. */
static void pair_crowded(pc_sheets *sheets, work *w, candidate *list, pc_index begin, pc_index end) {
    size_t count = 0;
    if (end - begin > PC_SHEETS_MOST_PAIRED) return;
    for (pc_index i = begin; i < end; i++)
        for (pc_index j = i + 1; j < end; j++)
            list[count++] = rate_pair(w, w->sorted.half[i], w->sorted.half[j]);
    qsort(list, count, sizeof *list, compare_candidates);
    for (size_t i = 0; i < count; i++) {
        pc_index h = list[i].h, g = list[i].g;
        uint8_t parity_h, parity_g, turn = needed_turn(w, h, g);
        if (sheets->twin[h] != PC_NONE || sheets->twin[g] != PC_NONE) continue;
        pc_index root_h = find_root(&w->forest, w->patch[h / 3], &parity_h);
        pc_index root_g = find_root(&w->forest, w->patch[g / 3], &parity_g);
        turn ^= parity_h ^ parity_g;
        if (root_h == root_g && turn) continue;
        if (root_h != root_g) unite(&w->forest, root_h, root_g, turn);
        shorten_path(&w->forest, w->patch[h / 3]);
        shorten_path(&w->forest, w->patch[g / 3]);
        sheets->twin[h] = g, sheets->twin[g] = h;
    }
}

static pc_status pair_all_crowded(pc_sheets *sheets, pc_context *ctx, work *w) {
    pc_status status = PC_OK;
    candidate *list = NULL;
    if (!sheets->crowded_count) return PC_OK;
    PC_TRY(pc_new(&list, ctx, PC_SHEETS_MOST_PAIRED * (PC_SHEETS_MOST_PAIRED - 1) / 2));
    for (pc_index c = 0; c < sheets->crowded_count; c++)
        pair_crowded(sheets, w, list, w->crowded[2 * c], w->crowded[2 * c + 1]);
done:
    pc_free(ctx, list);
    return status;
}

/* What decides how a piece is turned. */
typedef struct piece_votes {
    pc_index kept, turned;
    bool open;
    double volume; /* six times, with `flip` as it is before the decision */
} piece_votes;

static double face_volume(const pc_mesh *mesh, pc_index f, pc_vec3 origin, bool flip) {
    const pc_index *t = mesh->triangle + 3 * (size_t)f;
    pc_vec3 a = pc_sub(pc_vec3_at(mesh->position, t[0]), origin),
            b = pc_sub(pc_vec3_at(mesh->position, t[1]), origin);
    double volume = pc_dot(a, pc_cross(b, pc_sub(pc_vec3_at(mesh->position, t[2]), origin)));
    return flip ? -volume : volume;
}

static void number_pieces(pc_sheets *sheets, work *w, pc_index *number) {
    for (pc_index f = 0; f < w->mesh->face_count; f++) {
        uint8_t parity;
        shorten_path(&w->forest, w->patch[f]);
        pc_index root = find_root(&w->forest, w->patch[f], &parity);
        if (number[root] == PC_NONE) number[root] = sheets->piece_count++;
        sheets->piece[f] = number[root];
        sheets->flip[f] = w->turned[f] ^ parity;
    }
}

static void cast_votes(piece_votes *votes, const pc_sheets *sheets, const pc_mesh *mesh) {
    pc_vec3 origin = pc_geometry_box(mesh).low;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        piece_votes *vote = &votes[sheets->piece[f]];
        vote->kept += !sheets->flip[f];
        vote->turned += sheets->flip[f];
        vote->volume += face_volume(mesh, f, origin, sheets->flip[f]);
        for (pc_index h = 3 * f; h < 3 * f + 3; h++)
            if (sheets->twin[h] == PC_NONE) vote->open = true;
    }
}

static pc_status decide_flips(pc_sheets *sheets, pc_context *ctx, work *w, pc_index patch_count) {
    pc_status status = PC_OK;
    pc_index *number = NULL;
    piece_votes *votes = NULL;
    PC_TRY(pc_new(&number, ctx, patch_count));
    for (pc_index p = 0; p < patch_count; p++)
        number[p] = PC_NONE;
    number_pieces(sheets, w, number);
    PC_TRY(pc_new(&votes, ctx, sheets->piece_count));
    cast_votes(votes, sheets, w->mesh);
    for (pc_index f = 0; f < w->mesh->face_count; f++) {
        const piece_votes *vote = &votes[sheets->piece[f]];
        bool mixed = vote->kept && vote->turned;
        bool turn = vote->turned > vote->kept;
        if (mixed && !vote->open && vote->volume != 0) turn = vote->volume < 0;
        sheets->flip[f] ^= (uint8_t)turn;
    }
done:
    pc_free(ctx, number);
    pc_free(ctx, votes);
    return status;
}

static pc_status gather_torn(pc_sheets *sheets, pc_context *ctx, const work *w) {
    pc_status status = PC_OK;
    pc_index count = 0;
    PC_TRY(pc_new(&sheets->torn, ctx, sheets->torn_count));
    for (pc_index v = 0; sheets->torn_count && v < w->mesh->vertex_count; v++)
        for (pc_index i = w->sorted.start[v], end = w->sorted.start[v + 1], next; i < end; i = next) {
            pc_index h = w->sorted.half[i];
            next = pc_run_end(&w->sorted, w->mesh, i, end);
            if (next - i != 2 || sheets->twin[h] != PC_NONE) continue;
            sheets->torn[count++] = h;
            mark_ends(sheets, w->mesh, h);
        }
done:
    return status;
}

static pc_status make_arrays(pc_sheets *sheets, pc_context *ctx, work *w) {
    pc_status status = PC_OK;
    size_t face_count = w->mesh->face_count, crowded;
    PC_TRY(pc_halfsort_make(&w->sorted, ctx, w->mesh));
    crowded = count_crowded(w);
    PC_TRY(pc_new(&w->crowded, ctx, 2 * crowded));
    PC_TRY(pc_new(&sheets->crowded, ctx, crowded));
    PC_TRY(pc_new(&sheets->twin, ctx, 3 * face_count));
    PC_TRY(pc_new(&sheets->flip, ctx, face_count));
    PC_TRY(pc_new(&sheets->piece, ctx, face_count));
    PC_TRY(pc_new(&sheets->vertex_cut, ctx, w->mesh->vertex_count));
    PC_TRY(pc_new(&w->patch, ctx, face_count));
    PC_TRY(pc_new(&w->turned, ctx, face_count));
    PC_TRY(pc_new(&w->single, ctx, 3 * face_count));
    for (size_t h = 0; h < 3 * face_count; h++)
        sheets->twin[h] = PC_NONE;
done:
    return status;
}

static void free_work(work *w, pc_context *ctx) {
    pc_halfsort_free(&w->sorted, ctx);
    pc_free(ctx, w->crowded);
    pc_free(ctx, w->patch);
    pc_free(ctx, w->turned);
    pc_free(ctx, w->single);
    pc_free(ctx, w->forest.parent);
    pc_free(ctx, w->forest.parity);
}

pc_status pc_sheets_make(pc_sheets *sheets, pc_context *ctx, const pc_mesh *mesh) {
    pc_status status = PC_OK;
    work w = {.mesh = mesh};
    pc_index *queue = NULL, patch_count;
    *sheets = (pc_sheets){0};
    PC_TRY(make_arrays(sheets, ctx, &w));
    PC_TRY(pc_new(&queue, ctx, mesh->face_count));
    glue_pairs(sheets, &w);
    patch_count = orient_patches(sheets, &w, queue);
    PC_TRY(gather_torn(sheets, ctx, &w));
    PC_TRY(pc_new(&w.forest.parent, ctx, patch_count));
    PC_TRY(pc_new(&w.forest.parity, ctx, patch_count));
    for (pc_index p = 0; p < patch_count; p++)
        w.forest.parent[p] = p;
    PC_TRY(pair_all_crowded(sheets, ctx, &w));
    PC_TRY(decide_flips(sheets, ctx, &w, patch_count));
done:
    pc_free(ctx, queue);
    free_work(&w, ctx);
    if (status != PC_OK) pc_sheets_free(sheets, ctx);
    return status;
}

void pc_sheets_free(pc_sheets *sheets, pc_context *ctx) {
    if (!sheets) return;
    pc_free(ctx, sheets->twin);
    pc_free(ctx, sheets->flip);
    pc_free(ctx, sheets->piece);
    pc_free(ctx, sheets->vertex_cut);
    pc_free(ctx, sheets->crowded);
    pc_free(ctx, sheets->torn);
    *sheets = (pc_sheets){0};
}
