#include "mosaic.h"
#include "memory.h"
#include <string.h>

static pc_status allocate(pc_mosaic *m, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t sides = 2 * (size_t)m->arc_count;
    PC_TRY(pc_new(&m->degree, ctx, m->node_count));
    PC_TRY(pc_new(&m->border, ctx, m->node_count));
    PC_TRY(pc_new(&m->tail, ctx, sides));
    PC_TRY(pc_new(&m->next, ctx, sides));
    PC_TRY(pc_new(&m->prev, ctx, sides));
    PC_TRY(pc_new(&m->cell, ctx, sides));
    PC_TRY(pc_new(&m->angle, ctx, sides));
    PC_TRY(pc_new(&m->length, ctx, m->arc_count));
    PC_TRY(pc_new(&m->via, ctx, m->arc_count));
    PC_TRY(pc_new(&m->first, ctx, m->cell_count));
    PC_TRY(pc_new(&m->joined, ctx, m->cell_count));
    PC_TRY(pc_new(&m->area, ctx, m->cell_count));
    PC_TRY(pc_new(&m->scratch, ctx, m->cell_count));
done:
    return status;
}

static void link_cells(pc_mosaic *m, const pc_layout *l) {
    for (pc_index i = 0; i < 2 * m->arc_count; i++) {
        m->tail[i] = l->arc_node[i];
        m->cell[i] = l->arc_cell[i];
        m->next[i] = m->prev[i] = PC_NONE;
        m->degree[m->tail[i]]++;
        if (m->cell[i] == PC_NONE) m->border[m->tail[i]] = m->border[l->arc_node[i ^ 1]] = 1;
    }
    for (pc_index c = 0; c < m->cell_count; c++) {
        pc_index from = l->cell_start[c], to = l->cell_start[c + 1];
        m->first[c] = l->cell_side[from];
        m->joined[c] = c;
        for (pc_index i = from; i < to; i++) {
            pc_index side = l->cell_side[i], next = l->cell_side[i + 1 < to ? i + 1 : from];
            m->next[side] = next;
            m->prev[next] = side;
        }
    }
}

/* Adds `angle` to the corner of the cell at the node; where the rim comes by it several times, to each its
 * part. */
static void add_angle(pc_mosaic *m, pc_index cell, pc_index node, double angle) {
    pc_index visits = 0, s = m->first[cell];
    for (int pass = 0; pass < 2; pass++)
        do {
            if (m->tail[s] == node) {
                if (pass == 0) visits++;
                if (pass == 1) m->angle[s] += angle / visits;
            }
            s = m->next[s];
        } while (s != m->first[cell]);
}

static pc_status measure(pc_mosaic *m, pc_context *ctx, const pc_layout *l) {
    pc_status status = PC_OK;
    pc_index *node = NULL;
    const double *p = l->mesh.position;
    PC_TRY(pc_new(&node, ctx, l->mesh.vertex_count));
    memset(node, 0xff, sizeof *node * l->mesh.vertex_count);
    for (pc_index n = 0; n < l->node_count; n++)
        node[l->node_vertex[n]] = n;
    for (pc_index h = 0; h < 3 * l->mesh.face_count; h++) {
        pc_index v = l->mesh.triangle[h], c = l->cell[h / 3];
        pc_vec3 a = pc_vec3_at(p, v);
        pc_vec3 ab = pc_sub(pc_vec3_at(p, pc_head(&l->mesh, h)), a);
        pc_vec3 ac = pc_sub(pc_vec3_at(p, pc_tail(&l->mesh, pc_prev(h))), a);
        double twice = pc_norm(pc_cross(ab, ac));
        if (h % 3 == 0) m->area[c] += twice / 2;
        if (node[v] != PC_NONE) add_angle(m, c, node[v], atan2(twice, pc_dot(ab, ac)));
    }
    for (pc_index a = 0; a < m->arc_count; a++) {
        m->via[a] = PC_NONE;
        for (pc_index i = l->arc_start[a] + 1; i < l->arc_start[a + 1]; i++)
            m->length[a] += pc_distance(pc_vec3_at(p, l->arc_vertex[i - 1]), pc_vec3_at(p, l->arc_vertex[i]));
    }
done:
    pc_free(ctx, node);
    return status;
}

pc_status pc_mosaic_make(pc_mosaic *mosaic, pc_context *ctx, const pc_layout *layout) {
    pc_status status = PC_OK;
    *mosaic = (pc_mosaic){.layout = layout,
                          .node_count = layout->node_count,
                          .arc_count = layout->arc_count,
                          .cell_count = layout->cell_count};
    PC_TRY(allocate(mosaic, ctx));
    link_cells(mosaic, layout);
    PC_TRY(measure(mosaic, ctx, layout));
done:
    if (status != PC_OK) pc_mosaic_free(mosaic, ctx);
    return status;
}

void pc_mosaic_free(pc_mosaic *mosaic, pc_context *ctx) {
    if (!mosaic) return;
    pc_free(ctx, mosaic->degree);
    pc_free(ctx, mosaic->border);
    pc_free(ctx, mosaic->tail);
    pc_free(ctx, mosaic->next);
    pc_free(ctx, mosaic->prev);
    pc_free(ctx, mosaic->cell);
    pc_free(ctx, mosaic->angle);
    pc_free(ctx, mosaic->length);
    pc_free(ctx, mosaic->via);
    pc_free(ctx, mosaic->first);
    pc_free(ctx, mosaic->joined);
    pc_free(ctx, mosaic->area);
    pc_free(ctx, mosaic->scratch);
    *mosaic = (pc_mosaic){0};
}

bool pc_mosaic_is_pinched(const pc_mosaic *m, pc_index cell) {
    pc_index s = m->first[cell];
    do {
        for (pc_index t = m->next[s]; t != m->first[cell]; t = m->next[t])
            if (m->tail[t] == m->tail[s]) return true;
        s = m->next[s];
    } while (s != m->first[cell]);
    return false;
}

/* ---- check ---- */

static pc_status check_side(const pc_mosaic *m, pc_context *ctx, pc_index s) {
    pc_index cell = m->cell[s];
    if (m->tail[s] == PC_NONE) /* gone */
        return cell == PC_NONE && m->tail[s ^ 1] == PC_NONE ? PC_OK
                                                            : pc_fail(ctx, PC_E_BUG, "half of arc %u", s / 2);
    if (cell != PC_NONE && cell == m->cell[s ^ 1])
        return pc_fail(ctx, PC_E_BUG, "cell %u meets itself along arc %u", cell, s / 2);
    if (m->tail[s] == m->tail[s ^ 1]) return pc_fail(ctx, PC_E_BUG, "arc %u is a loop", s / 2);
    if (cell == PC_NONE) return PC_OK;
    if (m->first[cell] == PC_NONE || m->joined[cell] != cell)
        return pc_fail(ctx, PC_E_BUG, "side %u belongs to cell %u, which is gone", s, cell);
    pc_index next = m->next[s];
    if (m->cell[next] != cell || m->prev[next] != s || m->tail[next] != m->tail[s ^ 1])
        return pc_fail(ctx, PC_E_BUG, "side %u is not followed by side %u", s, next);
    return PC_OK;
}

/* The rims of all cells together are all sides, each once. */
static pc_status check_rims(const pc_mosaic *m, pc_context *ctx, size_t sides) {
    size_t met = 0;
    for (pc_index c = 0; c < m->cell_count; c++) {
        pc_index s = m->first[c];
        if (s == PC_NONE) continue;
        do {
            if (m->cell[s] != c || ++met > sides)
                return pc_fail(ctx, PC_E_BUG, "the rim of cell %u does not close", c);
            s = m->next[s];
        } while (s != m->first[c]);
    }
    return met == sides ? PC_OK : pc_fail(ctx, PC_E_BUG, "%zu of %zu sides are on rims", met, sides);
}

pc_status pc_mosaic_check(const pc_mosaic *m, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *degree = NULL;
    int64_t chi = 0;
    size_t sides = 0;
    PC_TRY(pc_new(&degree, ctx, m->node_count));
    for (pc_index s = 0; s < 2 * m->arc_count; s++) {
        PC_TRY(check_side(m, ctx, s));
        if (m->tail[s] == PC_NONE) continue;
        degree[m->tail[s]]++;
        sides += m->cell[s] != PC_NONE;
        chi -= s % 2 == 0;
    }
    for (pc_index n = 0; n < m->node_count; n++) {
        chi += degree[n] > 0;
        if (degree[n] == m->degree[n]) continue;
        status = pc_fail(ctx, PC_E_BUG, "node %u has %u arcs, not %u", n, degree[n], m->degree[n]);
        goto done;
    }
    for (pc_index c = 0; c < m->cell_count; c++)
        chi += m->first[c] != PC_NONE;
    int64_t wanted = (int64_t)m->layout->node_count - m->layout->arc_count + m->layout->cell_count;
    if (chi != wanted) {
        status = pc_fail(ctx, PC_E_BUG, "the joined cells' Euler number is %lld, the layout's %lld",
                         (long long)chi, (long long)wanted);
        goto done;
    }
    PC_TRY(check_rims(m, ctx, sides));
done:
    pc_free(ctx, degree);
    return status;
}
