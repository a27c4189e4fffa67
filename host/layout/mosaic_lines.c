#include "memory.h"
#include "mosaic.h"
#include <stdlib.h>

/* A line from its first side on; each side leaves a node and has the line on. */
typedef struct line {
    pc_index side, count;
} line;

static pc_index count_corners(const pc_mosaic *m, pc_index cell) {
    pc_index count = 0, s = m->first[cell];
    do {
        count += !pc_mosaic_is_flat(m, s);
        s = m->next[s];
    } while (s != m->first[cell]);
    return count;
}

/* The side by which a line leaves the T-junction at which `side`'s cell is flat. */
static pc_index stem_of(const pc_mosaic *m, pc_index side) {
    pc_index turned = pc_mosaic_turn(m, side);
    return turned == PC_NONE ? PC_NONE : pc_mosaic_turn(m, turned);
}

/* How far it is from a cell's corner to the next one, along sides with T-junctions on them. */
static double run_ahead(const pc_mosaic *m, pc_index side) {
    double length = m->length[side / 2];
    for (pc_index s = m->next[side]; s != side && pc_mosaic_is_flat(m, s); s = m->next[s])
        length += m->length[s / 2];
    return length;
}

static double run_back(const pc_mosaic *m, pc_index side) {
    double length = m->length[side / 2];
    for (pc_index s = side; pc_mosaic_is_flat(m, s) && m->prev[s] != side; s = m->prev[s])
        length += m->length[m->prev[s] / 2];
    return length;
}

/* Whether the cells on both sides of the arc make one quad that is not too slim. */
static bool joins_well(const pc_mosaic *m, pc_index side, double slimmest) {
    pc_index left = m->cell[side], right = m->cell[side ^ 1];
    if (left == PC_NONE || right == PC_NONE) return false;
    if (count_corners(m, left) != 4 || count_corners(m, right) != 4) return false;
    double along = m->length[side / 2];
    double begin = run_back(m, m->prev[side]) + run_ahead(m, m->next[side ^ 1]);
    double end = run_ahead(m, m->next[side]) + run_back(m, m->prev[side ^ 1]);
    double across = (begin + end) / 2;
    return across < slimmest * along && along < slimmest * across;
}

/* Follows the line that leaves a T-junction by `side` to its end; 0 where it should stay. */
static pc_index follow(pc_mosaic *m, pc_index side, pc_index longest, double slimmest) {
    m->mark++;
    for (pc_index count = 1; count <= longest; count++) {
        if (!joins_well(m, side, slimmest)) return 0;
        pc_index left = m->cell[side], right = m->cell[side ^ 1], node = m->tail[side ^ 1];
        if (m->scratch[left] == m->mark || m->scratch[right] == m->mark) return 0;
        m->scratch[left] = m->scratch[right] = m->mark;
        if (m->border[node]) return m->degree[node] == 3 ? count : 0;
        pc_index ahead = pc_mosaic_turn(m, side ^ 1);
        if (m->degree[node] == 3) return pc_mosaic_is_flat(m, ahead) ? count : 0;
        if (m->degree[node] != 4) return 0;
        side = pc_mosaic_turn(m, ahead);
    }
    return 0;
}

static int shorter_first(const void *a, const void *b) {
    const line *p = a, *q = b;
    if (p->count != q->count) return p->count < q->count ? -1 : 1;
    return p->side < q->side ? -1 : p->side > q->side;
}

static bool is_stem(const pc_mosaic *m, pc_index side) {
    pc_index turned = pc_mosaic_turn(m, side);
    return turned != PC_NONE && m->degree[m->tail[side]] == 3 && !m->border[m->tail[side]] &&
           pc_mosaic_is_flat(m, turned);
}

static void drop_line(pc_mosaic *m, pc_index side, pc_index count) {
    for (pc_index i = 0; i < count; i++) {
        pc_index ahead = pc_mosaic_turn(m, side ^ 1);
        pc_index next = i + 1 < count ? pc_mosaic_turn(m, ahead) : PC_NONE;
        if (!pc_mosaic_join(m, m->cell[side], m->cell[side ^ 1])) return;
        side = next;
    }
}

pc_status pc_mosaic_drop_lines(pc_mosaic *m, pc_index *gone, pc_context *ctx, pc_index longest,
                               double slimmest) {
    pc_status status = PC_OK;
    line *lines = NULL;
    size_t count = 0;
    *gone = 0;
    PC_TRY(pc_new(&lines, ctx, m->node_count));
    for (pc_index s = 0; s < 2 * m->arc_count; s++) {
        if (m->tail[s] == PC_NONE || m->cell[s] == PC_NONE || !pc_mosaic_is_flat(m, s)) continue;
        if (m->border[m->tail[s]]) continue;
        pc_index stem = stem_of(m, s), length = stem == PC_NONE ? 0 : follow(m, stem, longest, slimmest);
        if (length) lines[count++] = (line){stem, length};
    }
    qsort(lines, count, sizeof *lines, shorter_first);
    for (size_t i = 0; i < count; i++) {
        /* Those dropped before may have changed it, or been it. */
        pc_index side = lines[i].side;
        if (m->tail[side] == PC_NONE || m->cell[side] == PC_NONE || !is_stem(m, side)) continue;
        if (follow(m, side, longest, slimmest) != lines[i].count) continue;
        drop_line(m, side, lines[i].count);
        ++*gone;
    }
done:
    pc_free(ctx, lines);
    return status;
}
