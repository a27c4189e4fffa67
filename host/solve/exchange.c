#include "exchange.h"
#include "event.h"
#include "memory.h"
#include <string.h>

extern const char pc_kernel_halo[];

/* What a member sends and gets on a level. */
typedef struct route {
    pc_index sent_start[PC_MOST_MEMBERS + 1];
    pc_index copied_start[PC_MOST_MEMBERS + 1];
    pc_buffer *sent; /* places */
} route;

typedef struct member {
    pc_device *device;
    pc_kernel *gather;
    pc_buffer *outbox; /* rows for the others, side by side */
    route *level;
    pc_index made;                      /* rows of the level that the first member holds */
    pc_event *arrival[PC_MOST_MEMBERS]; /* of the copies from each member */
    bool awaited;                       /* copies are on their way that no launch waits for yet */
} member;

struct pc_exchange {
    int member_count;
    int level_count;
    member member[PC_MOST_MEMBERS];
    pc_share_run *run;
    pc_index run_count;
    /* On the first member: */
    pc_kernel *scatter;
    pc_buffer *inbox; /* rows as the members made them */
    pc_buffer *inbox_place;
};

static pc_status make_routes(pc_exchange *x, pc_context *ctx, const pc_share *share, int m,
                             size_t row_bytes) {
    pc_status status = PC_OK;
    member *to = &x->member[m];
    size_t most = 0;
    PC_TRY(pc_kernel_get(&to->gather, ctx, to->device, pc_kernel_halo, "halo_gather"));
    PC_TRY(pc_new(&to->level, ctx, (size_t)share->level_count));
    for (int k = 0; k < share->level_count; k++) {
        const pc_share_rows *rows = pc_share_of(share, k, m);
        const size_t count = rows->sent_start[share->member_count];
        memcpy(to->level[k].sent_start, rows->sent_start, sizeof rows->sent_start);
        memcpy(to->level[k].copied_start, rows->copied_start, sizeof rows->copied_start);
        PC_TRY(pc_buffer_from(&to->level[k].sent, ctx, to->device, rows->sent, count * sizeof *rows->sent));
        to->made = rows->made_count;
        if (count > most) most = count;
    }
    PC_TRY(pc_buffer_make(&to->outbox, ctx, to->device, most * row_bytes));
done:
    return status;
}

/* Where the first member puts the rows that all have made. */
static pc_status make_inbox(pc_exchange *x, pc_context *ctx, const pc_share *share, size_t row_bytes) {
    pc_status status = PC_OK;
    pc_device *first = x->member[0].device;
    const pc_row_order *order = &pc_share_of(share, share->spread, 0)->order;
    pc_index *place = NULL;
    pc_index count = 0;
    PC_TRY(pc_new(&place, ctx, order->count));
    for (int m = 0; m < share->member_count; m++) {
        const pc_share_rows *rows = pc_share_of(share, share->spread, m);
        for (pc_index i = 0; i < rows->made_count; i++)
            place[count++] = order->place[rows->made[i]];
    }
    PC_TRY(pc_kernel_get(&x->scatter, ctx, first, pc_kernel_halo, "halo_scatter"));
    PC_TRY(pc_buffer_make(&x->inbox, ctx, first, count * row_bytes));
    PC_TRY(pc_buffer_from(&x->inbox_place, ctx, first, place, count * sizeof *place));
done:
    pc_free(ctx, place);
    return status;
}

pc_status pc_exchange_make(pc_exchange **exchange, pc_context *ctx, pc_device *device, const pc_share *share,
                           size_t row_bytes) {
    pc_status status = PC_OK;
    pc_exchange *x = NULL;
    *exchange = NULL;
    PC_TRY(pc_new(&x, ctx, 1));
    x->member_count = share->member_count;
    x->level_count = share->level_count;
    x->run_count = share->run_count;
    PC_TRY(pc_new(&x->run, ctx, share->run_count));
    memcpy(x->run, share->run, share->run_count * sizeof *x->run);
    for (int m = 0; m < x->member_count; m++) {
        x->member[m].device = pc_device_member(device, m);
        PC_TRY(make_routes(x, ctx, share, m, row_bytes));
    }
    if (share->spread < share->level_count) PC_TRY(make_inbox(x, ctx, share, row_bytes));
done:
    if (status == PC_OK)
        *exchange = x;
    else
        pc_exchange_free(x, ctx);
    return status;
}

void pc_exchange_free(pc_exchange *exchange, pc_context *ctx) {
    if (!exchange) return;
    for (int m = 0; m < exchange->member_count; m++) {
        member *of = &exchange->member[m];
        for (int k = 0; of->level && k < exchange->level_count; k++)
            pc_buffer_free(of->level[k].sent, ctx);
        for (int from = 0; from < exchange->member_count; from++)
            pc_event_free(of->arrival[from]);
        pc_buffer_free(of->outbox, ctx);
        pc_free(ctx, of->level);
    }
    pc_buffer_free(exchange->inbox, ctx);
    pc_buffer_free(exchange->inbox_place, ctx);
    pc_free(ctx, exchange->run);
    pc_free(ctx, exchange);
}

/* Lays a member's rows for the others side by side, once they have taken those of the last time; `*ready` is
 * also when the member's own copies are no longer read. */
static pc_status pack(pc_event **ready, pc_exchange *x, pc_context *ctx, int level, int m,
                      const pc_buffer *vector, size_t row_bytes) {
    pc_status status = PC_OK;
    member *from = &x->member[m];
    const route *out = &from->level[level];
    const pc_index count = out->sent_start[x->member_count];
    const uint32_t words = (uint32_t)(row_bytes / 4);
    pc_event *taken[PC_MOST_MEMBERS];
    for (int k = 0; k < x->member_count; k++)
        taken[k] = x->member[k].arrival[m];
    PC_TRY(pc_event_await(ctx, from->device, taken, (size_t)x->member_count));
    PC_TRY(pc_kernel_run(
        ctx, from->gather, (size_t)count * words, 0, 2 * (double)count * (double)row_bytes,
        PC_ARGS(PC_BUF(vector), PC_BUF(out->sent), PC_BUF(from->outbox), PC_U32(count), PC_U32(words))));
    PC_TRY(pc_event_mark(ready, ctx, from->device));
done:
    return status;
}

pc_status pc_exchange_start(pc_exchange *exchange, pc_context *ctx, int level, pc_buffer *const *vector,
                            const size_t *first, size_t row_bytes) {
    pc_status status = PC_OK;
    pc_event *ready[PC_MOST_MEMBERS] = {NULL};
    const int n = exchange->member_count;
    for (int m = 0; m < n; m++)
        PC_TRY(pack(&ready[m], exchange, ctx, level, m, vector[m], row_bytes));
    for (int m = 0; m < n; m++) {
        member *to = &exchange->member[m];
        const route *in = &to->level[level];
        for (int from = 0; from < n; from++) {
            const member *sender = &exchange->member[from];
            const size_t count = in->copied_start[from + 1] - in->copied_start[from];
            pc_event *both[2] = {ready[from], ready[m]};
            pc_event_free(to->arrival[from]);
            to->arrival[from] = NULL;
            if (count == 0) continue;
            PC_TRY(pc_event_copy_beside(
                &to->arrival[from], ctx, vector[m], (first[m] + in->copied_start[from]) * row_bytes,
                sender->outbox, sender->level[level].sent_start[m] * row_bytes, count * row_bytes, both));
            to->awaited = true;
        }
    }
done:
    for (int m = 0; m < n; m++)
        pc_event_free(ready[m]);
    return status;
}

pc_status pc_exchange_finish(pc_exchange *exchange, pc_context *ctx, int member_number) {
    member *to = &exchange->member[member_number];
    if (!to->awaited) return PC_OK;
    to->awaited = false;
    return pc_event_await(ctx, to->device, to->arrival, (size_t)exchange->member_count);
}

/* Copies into a buffer of the first member, once member m has computed what it has to send. */
static pc_status collect(pc_exchange *x, pc_context *ctx, int m, const pc_buffer *to, size_t to_offset,
                         const pc_buffer *from, size_t from_offset, size_t bytes) {
    pc_event *ready = NULL;
    pc_status status = pc_event_mark(&ready, ctx, x->member[m].device);
    if (status == PC_OK) status = pc_event_copy(ctx, to, to_offset, from, from_offset, bytes, ready);
    pc_event_free(ready);
    return status;
}

pc_status pc_exchange_gather(pc_exchange *exchange, pc_context *ctx, const pc_buffer *to,
                             pc_buffer *const *made, size_t row_bytes) {
    pc_status status = PC_OK;
    const uint32_t words = (uint32_t)(row_bytes / 4);
    size_t count = 0;
    for (int m = 0; m < exchange->member_count; m++) {
        const size_t rows = exchange->member[m].made;
        PC_TRY(collect(exchange, ctx, m, exchange->inbox, count * row_bytes, made[m], 0, rows * row_bytes));
        count += rows;
    }
    PC_TRY(pc_kernel_run(ctx, exchange->scatter, count * words, 0, 2 * (double)count * (double)row_bytes,
                         PC_ARGS(PC_BUF(exchange->inbox), PC_BUF(exchange->inbox_place), PC_BUF(to),
                                 PC_U32((uint32_t)count), PC_U32(words))));
done:
    return status;
}

pc_status pc_exchange_sums(pc_exchange *exchange, pc_context *ctx, const pc_buffer *to,
                           pc_buffer *const *partial, const size_t *count, size_t per_block) {
    pc_status status = PC_OK;
    pc_event *ready[PC_MOST_MEMBERS] = {NULL};
    for (int m = 0; m < exchange->member_count; m++)
        PC_TRY(pc_event_mark(&ready[m], ctx, exchange->member[m].device));
    for (pc_index k = 0; k < exchange->run_count; k++) {
        const pc_share_run *run = &exchange->run[k];
        const size_t from = run->first * per_block;
        size_t end = from + run->count * per_block;
        if (end > count[run->member]) end = count[run->member];
        PC_TRY(pc_event_copy(ctx, to, run->whole * per_block * sizeof(double), partial[run->member],
                             from * sizeof(double), (end - from) * sizeof(double), ready[run->member]));
    }
done:
    for (int m = 0; m < exchange->member_count; m++)
        pc_event_free(ready[m]);
    return status;
}

pc_status pc_exchange_tell(pc_exchange *exchange, pc_context *ctx, pc_buffer *const *scalars, size_t offset,
                           size_t bytes) {
    pc_event *there = NULL;
    pc_status status = pc_event_mark(&there, ctx, exchange->member[0].device);
    for (int m = 1; status == PC_OK && m < exchange->member_count; m++)
        status = pc_event_copy(ctx, scalars[m], offset, scalars[0], offset, bytes, there);
    pc_event_free(there);
    return status;
}
