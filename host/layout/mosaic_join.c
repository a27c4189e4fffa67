#include "mosaic.h"

enum { MOST_PASSES = 32, MOST_SIDES = 64 };

/* ---- joining two cells ---- */

/* The run of sides that `to` shares with `other`: from the first to the last of them on the rim of `to`.
 * False where they are not one run of arcs with nothing but their own nodes between. */
static bool shared_run(const pc_mosaic *m, pc_index to, pc_index other, pc_index *begin, pc_index *end) {
    pc_index start = m->first[to], s = start, shared = 0, inner = 0;
    *begin = *end = PC_NONE;
    do {
        bool here = m->cell[s ^ 1] == other, ahead = m->cell[m->next[s] ^ 1] == other;
        bool through = here && ahead && m->degree[m->tail[m->next[s]]] == 2;
        shared += here, inner += through;
        if (here && !through) *end = s;
        if (ahead && !through) *begin = m->next[s];
        s = m->next[s];
    } while (s != start);
    return shared > 0 && shared == inner + 1;
}

static void drop_arc(pc_mosaic *m, pc_index side) {
    m->cell[side] = m->cell[side ^ 1] = PC_NONE;
    m->next[side] = m->next[side ^ 1] = m->prev[side] = m->prev[side ^ 1] = PC_NONE;
    m->tail[side] = m->tail[side ^ 1] = PC_NONE;
}

static void link_sides(pc_mosaic *m, pc_index before, pc_index after) {
    m->next[before] = after;
    m->prev[after] = before;
}

/* The two arcs at a node that has no others become one, where polygons stay polygons. `side` leaves it. */
static void straighten(pc_mosaic *m, pc_index side) {
    pc_index node = m->tail[side], back, in, twin_side = PC_NONE;
    if (m->degree[node] != 2) return;
    in = m->prev[side], back = in ^ 1; /* the other side that leaves the node */
    pc_index a = m->cell[side], b = m->cell[back];
    if (m->tail[in] == m->tail[side ^ 1]) return;
    if (pc_mosaic_side_count(m, a) < 4 || (b != PC_NONE && pc_mosaic_side_count(m, b) < 4)) return;
    if (m->border[node] && (m->angle[side] < 0.75 * PC_PI || m->angle[side] > 1.25 * PC_PI)) return;
    /* in, side -> in; side^1, back -> back. */
    link_sides(m, in, m->next[side]);
    m->tail[back] = m->tail[side ^ 1];
    if (b != PC_NONE) {
        twin_side = m->prev[side ^ 1];
        m->angle[back] = m->angle[side ^ 1];
        link_sides(m, twin_side, back);
        m->first[b] = back;
    }
    m->first[a] = in;
    m->length[in / 2] += m->length[side / 2];
    m->via[in / 2] = node;
    m->degree[node] = 0;
    drop_arc(m, side);
}

bool pc_mosaic_join(pc_mosaic *m, pc_index to, pc_index other) {
    pc_index begin, end;
    if (!shared_run(m, to, other, &begin, &end)) return false;
    pc_index before = m->prev[begin], after = m->next[end];
    pc_index other_before = m->prev[end ^ 1], other_after = m->next[begin ^ 1];
    bool swallowed = other_after == (end ^ 1), swallows = after == begin;
    double at_begin = m->angle[begin], at_end = m->angle[end ^ 1];
    for (pc_index s = m->first[other], k = pc_mosaic_side_count(m, other); k > 0; k--, s = m->next[s])
        m->cell[s] = to;
    for (pc_index s = begin;; s = m->next[s]) {
        m->degree[m->tail[s]]--, m->degree[m->tail[s ^ 1]]--;
        if (s == end) break;
    }
    pc_index at_last = swallows ? other_after : after, at_first = swallowed ? after : other_after;
    if (swallowed || swallows) {
        m->angle[at_first] += at_begin + at_end;
        link_sides(m, swallows ? other_before : before, at_first);
    } else {
        m->angle[other_after] += at_begin;
        m->angle[after] += at_end;
        link_sides(m, before, other_after);
        link_sides(m, other_before, after);
    }
    for (pc_index s = begin, next;; s = next) {
        next = m->next[s];
        bool last = s == end;
        drop_arc(m, s);
        if (last) break;
    }
    m->first[to] = at_first;
    m->first[other] = PC_NONE;
    m->joined[other] = to;
    m->area[to] += m->area[other];
    straighten(m, at_first);
    /* The first straightening may have taken the side that leaves the other end, never its tail's arcs. */
    if (at_last != at_first && m->cell[at_last] != PC_NONE) straighten(m, at_last);
    return true;
}

/* ---- what a cell is worth ---- */

typedef struct rim {
    pc_index count;
    pc_index node[MOST_SIDES];
    double angle[MOST_SIDES];
    uint8_t less[MOST_SIDES]; /* arcs that the node is about to lose */
    double area;
} rim;

static bool add_corner(rim *r, pc_index node, double angle, int less) {
    if (r->count == MOST_SIDES) return false;
    r->node[r->count] = node;
    r->angle[r->count] = angle;
    r->less[r->count++] = (uint8_t)less;
    return true;
}

/* How far from a quad: corners too many or few, T-junctions, and what no mesh may have. */
static double cost_of(const pc_mosaic *m, const rim *r) {
    pc_index vertices = 0, corners = 0, reflex = 0;
    bool pinched = false;
    for (pc_index i = 0; i < r->count; i++) {
        pc_index degree = m->degree[r->node[i]] - r->less[i];
        if (degree == 2 && !m->border[r->node[i]]) continue; /* it will be straightened out */
        bool straight = r->angle[i] > 0.75 * PC_PI;
        if (degree == 2 && straight) continue;
        vertices++;
        corners += !(degree == 3 && straight);
        reflex += r->angle[i] > 1.35 * PC_PI;
        for (pc_index k = 0; k < i; k++)
            pinched = pinched || r->node[k] == r->node[i];
    }
    double off = corners > 4 ? corners - 4 : 4 - corners;
    return off + (vertices != 4 ? 0.5 : 0) + (corners < 3 ? 50 : 0) + (reflex ? 10 : 0) + (pinched ? 100 : 0);
}

static bool read_rim(rim *r, const pc_mosaic *m, pc_index cell) {
    pc_index s = m->first[cell];
    r->count = 0;
    r->area = m->area[cell];
    do {
        if (!add_corner(r, m->tail[s], m->angle[s], 0)) return false;
        s = m->next[s];
    } while (s != m->first[cell]);
    return true;
}

static double cost_of_cell(const pc_mosaic *m, pc_index cell) {
    rim r;
    return read_rim(&r, m, cell) ? cost_of(m, &r) : 1000;
}

/* The rim of two cells joined, node degrees as they will be. */
static bool read_joined_rim(rim *r, const pc_mosaic *m, pc_index begin, pc_index end) {
    pc_index before = m->prev[begin], after = m->next[end];
    pc_index other_before = m->prev[end ^ 1], other_after = m->next[begin ^ 1];
    bool swallowed = other_after == (end ^ 1), swallows = after == begin;
    r->count = 0;
    if (swallowed && swallows) return false; /* a sphere of two cells */
    if (swallowed || swallows) {
        pc_index s = swallowed ? after : other_after, last = swallowed ? before : other_before;
        if (!add_corner(r, m->tail[s], m->angle[s] + m->angle[begin] + m->angle[end ^ 1], 2)) return false;
        while (s != last) {
            s = m->next[s];
            if (!add_corner(r, m->tail[s], m->angle[s], 0)) return false;
        }
        return true;
    }
    if (!add_corner(r, m->tail[after], m->angle[after] + m->angle[end ^ 1], 1)) return false;
    for (pc_index s = after; s != before;) {
        s = m->next[s];
        if (!add_corner(r, m->tail[s], m->angle[s], 0)) return false;
    }
    if (!add_corner(r, m->tail[other_after], m->angle[other_after] + m->angle[begin], 1)) return false;
    for (pc_index s = other_after; s != other_before;) {
        s = m->next[s];
        if (!add_corner(r, m->tail[s], m->angle[s], 0)) return false;
    }
    return true;
}

/* What the cell opposite to a node of three arcs gains when it loses that node. */
static double cost_without(const pc_mosaic *m, pc_index side, double *now) {
    rim r;
    pc_index cell = m->cell[side], node = m->tail[side];
    *now = 0;
    if (cell == PC_NONE || !read_rim(&r, m, cell)) return 0;
    *now = cost_of(m, &r);
    for (pc_index i = 0; i < r.count; i++)
        if (r.node[i] == node) r.less[i] = 1;
    return cost_of(m, &r);
}

/* What joining the two would change in cost; INFINITY where it cannot be. */
static double gain_of(const pc_mosaic *m, pc_index to, pc_index other) {
    pc_index begin, end;
    rim r;
    if (!shared_run(m, to, other, &begin, &end) || !read_joined_rim(&r, m, begin, end)) return INFINITY;
    double change = cost_of(m, &r) - cost_of_cell(m, to) - cost_of_cell(m, other);
    pc_index ends[2] = {begin, end ^ 1};
    for (int k = 0; k < 2; k++) {
        double now, then;
        pc_index node = m->tail[ends[k]];
        if (m->degree[node] != 3 || m->border[node]) continue;
        then = cost_without(m, m->prev[ends[k]] ^ 1, &now);
        change += then - now;
    }
    return change;
}

/* ---- mending ---- */

static pc_index best_partner(const pc_mosaic *m, pc_index cell, double *best) {
    pc_index partner = PC_NONE, s = m->first[cell];
    *best = INFINITY;
    do {
        pc_index other = m->cell[s ^ 1];
        double change = other == PC_NONE ? INFINITY : gain_of(m, cell, other);
        if (change < *best - 1e-9) *best = change, partner = other;
        s = m->next[s];
    } while (s != m->first[cell]);
    return partner;
}

/* Joins that gain at least `least`, of cells that cost at least `from`. */
static pc_index mend_all(pc_mosaic *m, double from, double least) {
    pc_index joins = 0;
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        pc_index before = joins;
        for (pc_index c = 0; c < m->cell_count; c++) {
            double change;
            if (m->first[c] == PC_NONE || cost_of_cell(m, c) < from) continue;
            pc_index other = best_partner(m, c, &change);
            if (other != PC_NONE && change <= -least && pc_mosaic_join(m, c, other)) joins++;
        }
        if (joins == before) break;
    }
    return joins;
}

pc_index pc_mosaic_mend(pc_mosaic *m) {
    pc_index joins = mend_all(m, 10, 1);
    return joins + mend_all(m, 1, 1);
}

pc_index pc_mosaic_dissolve(pc_mosaic *m, const uint8_t *wanted) {
    pc_index joins = 0;
    for (pc_index c = 0; c < m->cell_count; c++) {
        double change;
        if (!wanted[c] || m->first[c] == PC_NONE) continue;
        pc_index other = best_partner(m, c, &change);
        if (other != PC_NONE && change < 90 && pc_mosaic_join(m, c, other)) joins++;
    }
    return joins ? joins + pc_mosaic_mend(m) : 0;
}
