#include "share.h"
#include "memory.h"
#include "parts.h"
#include <string.h>

_Static_assert(PC_MOST_MEMBERS <= 16, "a bit of uint16_t per member");

/* While a share is made: who makes each row of a level, and who has copies of it, a bit per member. */
typedef struct dealing {
    pc_share *share;
    const pc_multigrid *multigrid;
    const pc_row_order *const *order;
    pc_index slice_rows;
    uint8_t *maker[PC_MOST_LEVELS];
    uint16_t *copied[PC_MOST_LEVELS];
} dealing;

static pc_index block_count(const pc_row_order *order) {
    return (order->count + PC_SHARE_BLOCK - 1) / PC_SHARE_BLOCK;
}

/* stamp[c] = b for the blocks c that rows of block b couple to. */
static void stamp_block(pc_index *stamp, const pc_blockmat *a, const pc_row_order *order, pc_index b) {
    pc_index end = order->count - b * PC_SHARE_BLOCK;
    if (end > PC_SHARE_BLOCK) end = PC_SHARE_BLOCK;
    for (pc_index k = 0; k < end; k++) {
        pc_index row = order->row[b * PC_SHARE_BLOCK + k];
        for (pc_index e = a->start[row]; e < a->start[row + 1]; e++)
            stamp[order->place[a->column[e]] / PC_SHARE_BLOCK] = b;
    }
}

/* The blocks as vertices, with an edge where their rows couple. */
static pc_status block_graph(pc_graph *graph, pc_context *ctx, const pc_blockmat *a,
                             const pc_row_order *order) {
    pc_status status = PC_OK;
    pc_index *stamp = NULL;
    const pc_index n = block_count(order);
    *graph = (pc_graph){.vertex_count = n};
    PC_TRY(pc_new(&stamp, ctx, n));
    PC_TRY(pc_new(&graph->start, ctx, (size_t)n + 1));
    for (int pass = 0; pass < 2; pass++) {
        memset(stamp, 0xff, n * sizeof *stamp);
        for (pc_index b = 0; b < n; b++) {
            pc_index at = graph->start[b];
            stamp_block(stamp, a, order, b);
            for (pc_index c = 0; c < n; c++) {
                if (stamp[c] != b || c == b) continue;
                if (pass == 1) graph->neighbour[at] = c;
                at++;
            }
            graph->start[b + 1] = at;
        }
        if (pass == 0) PC_TRY(pc_new(&graph->neighbour, ctx, graph->start[n]));
    }
done:
    pc_free(ctx, stamp);
    if (status != PC_OK) pc_graph_free(graph, ctx);
    return status;
}

static pc_status list_runs(pc_share *share, pc_context *ctx, const pc_index *part, pc_index blocks) {
    pc_index had[PC_MOST_MEMBERS] = {0};
    pc_status status = pc_new(&share->run, ctx, blocks);
    if (status != PC_OK) return status;
    for (pc_index b = 0; b < blocks; b++) {
        const int m = (int)part[b];
        if (b == 0 || part[b] != part[b - 1])
            share->run[share->run_count++] = (pc_share_run){.member = m, .first = had[m], .whole = b};
        share->run[share->run_count - 1].count++;
        had[m]++;
    }
    return PC_OK;
}

static pc_status deal_blocks(dealing *d, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_row_order *order = d->order[0];
    pc_graph graph = {0};
    pc_parts parts = {0};
    PC_TRY(block_graph(&graph, ctx, &d->multigrid->level[0].matrix, order));
    PC_TRY(pc_parts_make(&parts, ctx, &graph, (pc_index)d->share->member_count));
    PC_TRY(list_runs(d->share, ctx, parts.vertex_part, graph.vertex_count));
    PC_TRY(pc_new(&d->maker[0], ctx, order->count));
    for (pc_index place = 0; place < order->count; place++)
        d->maker[0][order->row[place]] = (uint8_t)parts.vertex_part[place / PC_SHARE_BLOCK];
done:
    pc_graph_free(&graph, ctx);
    pc_parts_free(&parts, ctx);
    return status;
}

/* The rows of the next level follow the first rows of their groups. */
static pc_status deal_groups(dealing *d, pc_context *ctx, int level) {
    const pc_aggregates *groups = &d->multigrid->level[level - 1].aggregates;
    pc_status status = pc_new(&d->maker[level], ctx, groups->count);
    if (status != PC_OK) return status;
    for (pc_index g = 0; g < groups->count; g++)
        d->maker[level][g] = d->maker[level - 1][groups->member[groups->start[g]]];
    return PC_OK;
}

static int holder(const dealing *d, int level, pc_index row) {
    return level < d->share->spread ? d->maker[level][row] : 0;
}

/* Who computes rows of `a`, rows of `rows_level`, copies the columns that others hold. */
static void mark_copies(dealing *d, const pc_blockmat *a, const uint8_t *maker, int column_level) {
    uint16_t *copied = d->copied[column_level];
    for (pc_index i = 0; i < a->row_count; i++)
        for (pc_index e = a->start[i]; e < a->start[i + 1]; e++)
            if (holder(d, column_level, a->column[e]) != maker[i])
                copied[a->column[e]] |= (uint16_t)(1U << maker[i]);
}

static pc_status find_copies(dealing *d, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_level *level = d->multigrid->level;
    for (int k = 0; k < d->share->level_count; k++)
        PC_TRY(pc_new(&d->copied[k], ctx, level[k].matrix.row_count));
    for (int k = 0; k < d->share->spread; k++) {
        mark_copies(d, &level[k].matrix, d->maker[k], k);
        if (k + 1 == d->share->level_count) break;
        mark_copies(d, &level[k].prolongator, d->maker[k], k + 1);
        mark_copies(d, &level[k].restriction, d->maker[k + 1], k);
    }
done:
    return status;
}

/* Own and restricted rows of every member, in the level's order. */
static pc_status list_rows(dealing *d, pc_context *ctx, int k) {
    pc_status status = PC_OK;
    const pc_row_order *whole = d->order[k];
    for (int m = 0; m < d->share->member_count; m++) {
        pc_share_rows *rows = pc_share_of(d->share, k, m);
        pc_index count = 0;
        for (pc_index i = 0; i < whole->count; i++)
            count += d->maker[k][i] == m;
        pc_index *list = NULL;
        PC_TRY(pc_new(&list, ctx, count));
        count = 0;
        for (pc_index place = 0; place < whole->count; place++)
            if (d->maker[k][whole->row[place]] == m) list[count++] = whole->row[place];
        rows->order.count = k < d->share->spread ? count : m == 0 ? whole->count : 0;
        if (k < d->share->spread) {
            rows->order.row = list;
        } else {
            rows->made = list;
            rows->made_count = count;
            PC_TRY(pc_new(&rows->order.row, ctx, rows->order.count));
            memcpy(rows->order.row, whole->row, rows->order.count * sizeof *whole->row);
        }
        PC_TRY(pc_new(&rows->order.place, ctx, whole->count));
        memset(rows->order.place, 0xff, whole->count * sizeof *rows->order.place);
        for (pc_index place = 0; place < rows->order.count; place++)
            rows->order.place[rows->order.row[place]] = place;
    }
done:
    return status;
}

/* What member `from` sends, and where it goes. */
static pc_status list_copies(dealing *d, pc_context *ctx, int k, int from) {
    pc_share_rows *sender = pc_share_of(d->share, k, from);
    const pc_row_order *own = &sender->order;
    pc_index count = 0;
    for (pc_index i = 0; i < own->count; i++)
        for (unsigned bits = d->copied[k][own->row[i]]; bits; bits &= bits - 1)
            count++;
    pc_status status = pc_new(&sender->sent, ctx, count);
    if (status != PC_OK) return status;
    count = 0;
    for (int m = 0; m < d->share->member_count; m++) {
        pc_share_rows *to = pc_share_of(d->share, k, m);
        const pc_index first = (to->order.count + d->slice_rows - 1) / d->slice_rows * d->slice_rows;
        sender->sent_start[m] = count;
        to->copied_start[from] = to->order.copies;
        for (pc_index place = 0; place < own->count; place++) {
            if (!(d->copied[k][own->row[place]] >> m & 1)) continue;
            sender->sent[count++] = place;
            to->order.place[own->row[place]] = first + to->order.copies++;
        }
        to->copied_start[from + 1] = to->order.copies;
    }
    sender->sent_start[d->share->member_count] = count;
    return PC_OK;
}

pc_status pc_share_make(pc_share *share, pc_context *ctx, const pc_multigrid *multigrid,
                        const pc_row_order *const *order, int member_count, pc_index slice_rows,
                        pc_index least) {
    pc_status status = PC_OK;
    dealing d = {.share = share, .multigrid = multigrid, .order = order, .slice_rows = slice_rows};
    /* A level that is solved directly is one device's. */
    const int most = multigrid->level_count - (multigrid->inverse && multigrid->level_count > 1);
    *share = (pc_share){.member_count = member_count, .spread = 1};
    while (share->spread < most && order[share->spread]->count >= (uint64_t)least * (uint64_t)member_count)
        share->spread++;
    share->level_count = share->spread + (share->spread < multigrid->level_count);
    PC_TRY(pc_new(&share->rows, ctx, (size_t)share->level_count * (size_t)member_count));
    PC_TRY(deal_blocks(&d, ctx));
    for (int k = 1; k < share->level_count; k++)
        PC_TRY(deal_groups(&d, ctx, k));
    PC_TRY(find_copies(&d, ctx));
    for (int k = 0; k < share->level_count; k++) {
        PC_TRY(list_rows(&d, ctx, k));
        for (int m = 0; m < member_count; m++)
            PC_TRY(list_copies(&d, ctx, k, m));
    }
done:
    for (int k = 0; k < PC_MOST_LEVELS; k++) {
        pc_free(ctx, d.maker[k]);
        pc_free(ctx, d.copied[k]);
    }
    if (status != PC_OK) pc_share_free(share, ctx);
    return status;
}

void pc_share_free(pc_share *share, pc_context *ctx) {
    for (int i = 0; share->rows && i < share->level_count * share->member_count; i++) {
        pc_row_order_free(&share->rows[i].order, ctx);
        pc_free(ctx, share->rows[i].made);
        pc_free(ctx, share->rows[i].sent);
    }
    pc_free(ctx, share->rows);
    pc_free(ctx, share->run);
    *share = (pc_share){0};
}
