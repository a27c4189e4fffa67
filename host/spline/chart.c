#include "chart.h"
#include <math.h>
#include <string.h>

/* x in the frame of one face is turn(x) + offset in that of another. */
typedef struct frame {
    pc_index face;
    int quarters;
    double offset[2];
} frame;

static void turn(double x[2], int quarters) {
    for (; quarters > 0; quarters--) {
        const double s = x[0];
        x[0] = -x[1];
        x[1] = s;
    }
}

/* From the face beyond half-edge h to the face of h. */
static frame beyond(const pc_tmesh *mesh, pc_index h) {
    static const double along[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const pc_thalf *e = mesh->half + h, *twin = mesh->half + e->twin;
    frame f = {.face = twin->face, .quarters = (e->side - twin->side + 6) % 4};
    double here[2], there[2];
    pc_thalf_place(here, mesh, h);
    pc_thalf_place(there, mesh, e->twin);
    for (int k = 0; k < 2; k++)
        there[k] += along[twin->side][k] * twin->interval;
    turn(there, f.quarters);
    for (int k = 0; k < 2; k++)
        f.offset[k] = here[k] - there[k];
    return f;
}

static bool is_open(const pc_tmesh *mesh, pc_index h) {
    pc_index face = mesh->half[mesh->half[h].twin].face;
    return face != PC_NONE && !mesh->face[face].ghost;
}

static frame combine(const frame *outer, const frame *inner) {
    frame f = {.face = inner->face, .quarters = (outer->quarters + inner->quarters) % 4};
    double offset[2] = {inner->offset[0], inner->offset[1]};
    turn(offset, outer->quarters);
    for (int k = 0; k < 2; k++)
        f.offset[k] = outer->offset[k] + offset[k];
    return f;
}

bool pc_chart_between(double way[2], const pc_tmesh *mesh, const pc_spot *a, const pc_spot *b) {
    enum { MOST = 96 };
    frame known[MOST] = {{.face = a->face}};
    int count = 1, level = 1; /* the first of the last ring is where `level` stood before */
    double least = INFINITY;
    if (a->face == b->face) {
        for (int k = 0; k < 2; k++)
            way[k] = b->at[k] - a->at[k];
        return true;
    }
    for (int at = 0; at < count; at++) {
        if (at == level) { /* all ways that cross so many edges are known */
            if (least < INFINITY) break;
            level = count;
        }
        pc_index first = mesh->face[known[at].face].first, h = first;
        do {
            if (is_open(mesh, h) && count < MOST) {
                frame step = beyond(mesh, h), next = combine(known + at, &step);
                bool seen = false;
                for (int i = 0; i < count && !seen; i++)
                    seen = known[i].face == next.face && next.face != b->face;
                if (!seen) known[count++] = next;
                if (next.face == b->face) {
                    double x[2] = {b->at[0], b->at[1]};
                    turn(x, next.quarters);
                    for (int k = 0; k < 2; k++)
                        x[k] += next.offset[k] - a->at[k];
                    double length = x[0] * x[0] + x[1] * x[1];
                    if (length < least) least = length, memcpy(way, x, sizeof x);
                }
            }
            h = mesh->half[h].next;
        } while (h != first);
    }
    return least < INFINITY;
}

/* The half-edge of a side that a point of the side is on. */
static pc_index half_at(const pc_tmesh *mesh, const pc_spot *spot, int side) {
    const double *size = mesh->face[spot->face].size;
    double along = side == 0   ? spot->at[0]
                   : side == 1 ? spot->at[1]
                   : side == 2 ? size[0] - spot->at[0]
                               : size[1] - spot->at[1];
    pc_index h = mesh->face[spot->face].first;
    while (mesh->half[h].side != side)
        h = mesh->half[h].next;
    while (mesh->half[mesh->half[h].next].side == side && mesh->half[mesh->half[h].next].along <= along)
        h = mesh->half[h].next;
    return h;
}

/* How far along `way` the face reaches (1: all the way), and the side that it ends at. */
static double reach_of(int *side, const pc_tmesh *mesh, const pc_spot *spot, const double way[2]) {
    const double *size = mesh->face[spot->face].size;
    double part = 1;
    *side = -1;
    for (int k = 0; k < 2; k++) {
        double room = way[k] > 0 ? size[k] - spot->at[k] : spot->at[k];
        if (room >= part * fabs(way[k])) continue;
        part = room > 0 ? room / fabs(way[k]) : 0;
        *side = k == 0 ? (way[k] > 0 ? 1 : 3) : (way[k] > 0 ? 2 : 0);
    }
    return part;
}

pc_spot pc_chart_walk(const pc_tmesh *mesh, const pc_spot *from, const double way[2]) {
    enum { MOST_FACES = 64 };
    pc_spot spot = *from;
    double left[2] = {way[0], way[1]};
    for (int i = 0; i < MOST_FACES; i++) {
        int side;
        double part = reach_of(&side, mesh, &spot, left);
        for (int k = 0; k < 2; k++) {
            spot.at[k] = fmin(fmax(spot.at[k] + part * left[k], 0), mesh->face[spot.face].size[k]);
            left[k] *= 1 - part;
        }
        if (side < 0) break;
        pc_index h = half_at(mesh, &spot, side);
        if (!is_open(mesh, h)) break;
        frame f = beyond(mesh, h);
        for (int k = 0; k < 2; k++)
            spot.at[k] -= f.offset[k];
        turn(spot.at, 4 - f.quarters);
        turn(left, 4 - f.quarters);
        spot.face = f.face;
        for (int k = 0; k < 2; k++)
            spot.at[k] = fmin(fmax(spot.at[k], 0), mesh->face[spot.face].size[k]);
    }
    return spot;
}
