#include "closure.h"
#include "memory.h"
#include "suitable.h"
#include "tsplit.h"
#include <math.h>
#include <string.h>

/* A cut that is due. The face may have been cut since: then it is looked for again in the next round. */
typedef struct cut {
    pc_index face;
    int direction;
    double at;
} cut;

typedef struct closing {
    pc_tmesh *mesh;
    cut *due;
    size_t count, room;
    pc_index *star; /* extraordinary vertices whose surroundings are due */
    size_t star_count, star_room;
    uint8_t *touched; /* per face: cut in this round */
    size_t touched_room;
    uint8_t *notched; /* per face: there is a T-junction in a side of it */
    pc_closure_stats *stats;
} closing;

static pc_status want_star(closing *c, pc_context *ctx, pc_index v) {
    pc_status status = PC_OK;
    for (size_t i = 0; i < c->star_count; i++)
        if (c->star[i] == v) return PC_OK;
    if (c->star_count == c->star_room) {
        PC_TRY(pc_resize(&c->star, ctx, 2 * c->star_room + 16));
        c->star_room = 2 * c->star_room + 16;
    }
    c->star[c->star_count++] = v;
done:
    return status;
}

/* A cut of an irregular face is one of the whole surroundings of its extraordinary vertices. */
static pc_status want(closing *c, pc_context *ctx, pc_index f, int direction, double at) {
    pc_status status = PC_OK;
    if (pc_tface_is_irregular(c->mesh, f)) {
        pc_index first = c->mesh->face[f].first, h = first;
        do {
            if (c->mesh->vertex[c->mesh->half[h].tail].extraordinary)
                PC_TRY(want_star(c, ctx, c->mesh->half[h].tail));
            h = c->mesh->half[h].next;
        } while (h != first);
        return PC_OK;
    }
    if (c->count == c->room) {
        PC_TRY(pc_resize(&c->due, ctx, 2 * c->room + 64));
        c->room = 2 * c->room + 64;
    }
    c->due[c->count++] = (cut){f, direction, at};
done:
    return status;
}

/* The cut of its face that starts at the T-junction at the tail of h. */
static pc_status want_through(closing *c, pc_context *ctx, pc_index h) {
    double at[2];
    pc_thalf_place(at, c->mesh, h);
    int direction = c->mesh->half[h].side & 1;
    return want(c, ctx, c->mesh->half[h].face, direction, at[direction]);
}

/* All T-junctions in the sides of face f (`which` < 0), or in one side. */
static pc_status want_flat(closing *c, pc_context *ctx, pc_index f, int which) {
    pc_status status = PC_OK;
    pc_index first = c->mesh->face[f].first, h = first;
    if (!c->notched[f]) return PC_OK;
    do {
        if (!pc_thalf_turns(c->mesh, h) && (which < 0 || c->mesh->half[h].side == which))
            PC_TRY(want_through(c, ctx, h));
        h = c->mesh->half[h].next;
    } while (h != first);
done:
    return status;
}

/* The faces around one with an extraordinary corner, and those after them. */
static pc_status inspect_surroundings(closing *c, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = c->mesh;
    pc_index first = mesh->face[f].first, h = first;
    PC_TRY(want_flat(c, ctx, f, -1));
    do {
        pc_index e = h;
        do {
            pc_index r = mesh->half[e].face, g = mesh->face[r].first;
            PC_TRY(want_flat(c, ctx, r, -1));
            do { /* across each side of r */
                const pc_thalf *twin = mesh->half + mesh->half[g].twin;
                if (twin->face != PC_NONE) {
                    PC_TRY(want_flat(c, ctx, twin->face, (twin->side + 1) & 3));
                    PC_TRY(want_flat(c, ctx, twin->face, (twin->side + 3) & 3));
                }
                g = mesh->half[g].next;
            } while (g != mesh->face[r].first);
            e = pc_thalf_ccw(mesh, e);
        } while (e != h);
        h = mesh->half[h].next;
    } while (h != first);
done:
    return status;
}

static bool is_ghost(const pc_tmesh *mesh, pc_index f) {
    return f == PC_NONE || mesh->face[f].ghost;
}

/* T-junctions that face each other, and those that stand before a ghost. */
static pc_status inspect_sides(closing *c, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = c->mesh;
    pc_index first = mesh->face[f].first, h = first, g;
    do {
        const pc_thalf *e = mesh->half + h;
        if (e->along > 0 && mesh->face[f].ghost && !is_ghost(mesh, mesh->half[e->twin].face))
            PC_TRY(want_through(c, ctx, h));
        if (e->along > 0 && e->side < 2) {
            double facing = mesh->face[f].size[e->side] - e->along;
            for (g = e->next; g != first; g = mesh->half[g].next)
                if (mesh->half[g].side == e->side + 2 && mesh->half[g].along == facing)
                    PC_TRY(want_through(c, ctx, h));
        }
        h = e->next;
    } while (h != first);
done:
    return status;
}

/* Of the two T-junctions whose extensions cross, the one whose cut ends at a vertex, else the one that
 * crosses less of a face goes on. */
static double price(const pc_tmesh *mesh, pc_index h) {
    const pc_thalf *e = mesh->half + h;
    const pc_tface *face = mesh->face + e->face;
    double facing = face->size[e->side & 1] - e->along;
    if (pc_tface_is_irregular(mesh, e->face)) return 1e300;
    for (pc_index g = e->next; g != h; g = mesh->half[g].next)
        if (mesh->half[g].side == ((e->side + 2) & 3) && mesh->half[g].along == facing) return 0;
    return face->size[(e->side + 1) & 1];
}

static pc_status inspect_crossings(closing *c, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_crossing *crossing = NULL;
    size_t count = 0;
    PC_TRY(pc_suitable_crossings(&crossing, &count, &c->stats->junctions, ctx, c->mesh));
    for (size_t i = 0; i < count; i++) {
        pc_index a = pc_suitable_junction(c->mesh, crossing[i].junction[0]);
        pc_index b = pc_suitable_junction(c->mesh, crossing[i].junction[1]);
        double first = price(c->mesh, a), second = price(c->mesh, b);
        bool other = second < first || (second == first && crossing[i].junction[1] < crossing[i].junction[0]);
        PC_TRY(want_through(c, ctx, other ? b : a));
    }
done:
    pc_free(ctx, crossing);
    return status;
}

static pc_status find_notches(closing *c, pc_context *ctx) {
    const pc_tmesh *mesh = c->mesh;
    pc_free(ctx, c->notched);
    const pc_status status = pc_new(&c->notched, ctx, mesh->face_count);
#pragma omp parallel for schedule(static)
    for (pc_index f = 0; f < (status == PC_OK ? mesh->face_count : 0); f++) {
        pc_index h = mesh->face[f].first;
        do {
            c->notched[f] |= !pc_thalf_turns(mesh, h);
            h = mesh->half[h].next;
        } while (h != mesh->face[f].first);
    }
    return status;
}

/* All that is due; the crossings last and only where there is nothing else. */
static pc_status inspect(closing *c, pc_context *ctx) {
    pc_status status = PC_OK;
    c->count = c->star_count = 0;
    PC_TRY(find_notches(c, ctx));
    for (pc_index f = 0; f < c->mesh->face_count; f++) {
        if (!c->mesh->face[f].ghost && pc_tface_is_irregular(c->mesh, f))
            PC_TRY(inspect_surroundings(c, ctx, f));
        PC_TRY(inspect_sides(c, ctx, f));
    }
    if (c->count + c->star_count == 0) PC_TRY(inspect_crossings(c, ctx));
done:
    return status;
}

/* Cuts all faces around the vertex in four, and around those that share a face with it. */
static pc_status cut_star(closing *c, pc_context *ctx, size_t i) {
    pc_status status = PC_OK;
    pc_tmesh *mesh = c->mesh;
    pc_index v = c->star[i], first = mesh->vertex[v].out, h = first;
    do {
        pc_index f = mesh->half[h].face;
        pc_index start = mesh->face[f].first, g = start;
        if (!c->touched[f]) {
            do {
                if (mesh->vertex[mesh->half[g].tail].extraordinary)
                    PC_TRY(want_star(c, ctx, mesh->half[g].tail));
                g = mesh->half[g].next;
            } while (g != start);
            PC_TRY(pc_tsplit_face_in_four(mesh, ctx, f));
            c->touched[f] = 1;
            memset(c->touched + mesh->face_count - 3, 1, 3);
            c->stats->cuts += 3;
        }
        h = pc_thalf_ccw(mesh, h);
    } while (h != first);
    if (mesh->vertex[v].depth > 0) mesh->vertex[v].depth--;
done:
    return status;
}

static pc_status carry_out(closing *c, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t faces = 4 * (size_t)c->mesh->face_count; /* four may come of each */
    if (!c->touched || c->touched_room < faces) {
        PC_TRY(pc_resize(&c->touched, ctx, 2 * faces));
        c->touched_room = 2 * faces;
    }
    memset(c->touched, 0, c->touched_room);
    for (size_t i = 0; i < c->star_count; i++)
        PC_TRY(cut_star(c, ctx, i));
    for (size_t i = 0; i < c->count; i++) {
        const cut *due = c->due + i;
        if (c->touched[due->face]) continue;
        c->touched[due->face] = 1;
        c->stats->cuts++;
        PC_TRY(pc_tsplit_face(c->mesh, ctx, due->face, due->direction, due->at));
    }
done:
    return status;
}

/* All that is due, and what that makes due. */
static pc_status close_mesh(closing *c, pc_context *ctx) {
    pc_status status = PC_OK;
    do {
        PC_TRY(carry_out(c, ctx));
        PC_TRY(pc_check_interrupt(ctx));
        PC_TRY(inspect(c, ctx));
        c->stats->rounds++;
    } while (c->count + c->star_count > 0);
done:
    return status;
}

static void drop_closing(closing *c, pc_context *ctx) {
    pc_free(ctx, c->due);
    pc_free(ctx, c->star);
    pc_free(ctx, c->touched);
    pc_free(ctx, c->notched);
}

pc_status pc_closure_refine(pc_tmesh *mesh, pc_closure_stats *stats, pc_context *ctx, const uint8_t *wish) {
    pc_status status = PC_OK;
    closing c = {.mesh = mesh, .stats = stats};
    pc_index faces = mesh->face_count;
    *stats = (pc_closure_stats){0};
    pc_tsplit_start(mesh);
    for (pc_index f = 0; f < faces; f++) {
        stats->asked += (wish[f] & 1) + (wish[f] >> 1 & 1);
        if (wish[f] && pc_tface_is_irregular(mesh, f)) PC_TRY(want(&c, ctx, f, 0, 0));
    }
    for (pc_index f = 0; f < faces; f++) { /* before the stars: their numbers are still good */
        if (!wish[f] || pc_tface_is_irregular(mesh, f)) continue;
        double half[2] = {mesh->face[f].size[0] / 2, mesh->face[f].size[1] / 2};
        stats->cuts += (wish[f] & 1) + (wish[f] >> 1 & 1);
        if (wish[f] == (PC_HALVE_S | PC_HALVE_T))
            PC_TRY(pc_tsplit_face_in_four(mesh, ctx, f));
        else
            PC_TRY(pc_tsplit_face(mesh, ctx, f, wish[f] == PC_HALVE_T, half[wish[f] == PC_HALVE_T]));
    }
    PC_TRY(close_mesh(&c, ctx));
done:
    drop_closing(&c, ctx);
    return status;
}

/* Cuts the face of h, which leaves an extraordinary vertex, down to `size` from there, both ways. */
static pc_status trim_corner(closing *c, pc_context *ctx, pc_index h, double size) {
    pc_status status = PC_OK;
    pc_tmesh *mesh = c->mesh;
    for (int d = 0; d < 2; d++) {
        const pc_tface *face = mesh->face + mesh->half[h].face;
        const int corner = mesh->half[h].side; /* the number of the face's corner at the vertex */
        const bool high = d == 0 ? corner == 1 || corner == 2 : corner >= 2;
        if (!(face->size[d] > size)) continue;
        PC_TRY(pc_tsplit_face(mesh, ctx, mesh->half[h].face, d, high ? face->size[d] - size : size));
        c->stats->cuts++;
    }
done:
    return status;
}

/* Squares of the shortest interval around every extraordinary vertex: others are cut. */
static pc_status even_stars(closing *c, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_tmesh *mesh = c->mesh;
    pc_index before;
    do {
        before = mesh->face_count;
        for (pc_index v = 0; v < mesh->vertex_count; v++) {
            double least = INFINITY;
            pc_index first = mesh->vertex[v].out, h = first;
            if (!mesh->vertex[v].extraordinary) continue;
            do {
                least = fmin(least, mesh->half[h].interval);
                h = pc_thalf_ccw(mesh, h);
            } while (h != first);
            do {
                PC_TRY(trim_corner(c, ctx, h, least));
                h = pc_thalf_ccw(mesh, h);
            } while (h != first);
        }
    } while (mesh->face_count != before);
done:
    return status;
}

pc_status pc_closure_settle(pc_tmesh *mesh, pc_closure_stats *stats, pc_context *ctx) {
    pc_status status = PC_OK;
    closing c = {.mesh = mesh, .stats = stats};
    *stats = (pc_closure_stats){0};
    pc_tsplit_start(mesh);
    PC_TRY(even_stars(&c, ctx));
    PC_TRY(close_mesh(&c, ctx));
done:
    drop_closing(&c, ctx);
    return status;
}

pc_status pc_closure_check(const pc_tmesh *mesh, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_closure_stats stats = {0};
    pc_tmesh copy = {0};
    closing c = {.stats = &stats};
    PC_TRY(pc_tmesh_copy(&copy, ctx, mesh));
    c.mesh = &copy;
    PC_TRY(inspect(&c, ctx));
    if (c.star_count)
        PC_TRY(pc_fail(ctx, PC_E_BUG, "T-junctions come near vertex %u of the T-mesh", c.star[0]));
    if (c.count)
        PC_TRY(pc_fail(ctx, PC_E_BUG, "face %u of the T-mesh needs a cut: not analysis-suitable",
                       c.due[0].face));
done:
    drop_closing(&c, ctx);
    pc_tmesh_free(&copy, ctx);
    return status;
}
