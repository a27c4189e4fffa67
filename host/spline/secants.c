#include "secants.h"
#include "hostvec.h"
#include "memory.h"
#include <string.h>

pc_status pc_secants_make(pc_secants *secants, pc_context *ctx, size_t length) {
    pc_status status = PC_OK;
    *secants = (pc_secants){.length = length};
    for (int k = 0; k < PC_SECANTS_KEPT; k++) {
        PC_TRY(pc_new(&secants->step[k], ctx, length));
        PC_TRY(pc_new(&secants->change[k], ctx, length));
    }
    PC_TRY(pc_new(&secants->last_pull, ctx, length));
    PC_TRY(pc_new(&secants->last_step, ctx, length));
done:
    if (status != PC_OK) pc_secants_free(secants, ctx);
    return status;
}

void pc_secants_free(pc_secants *secants, pc_context *ctx) {
    for (int k = 0; k < PC_SECANTS_KEPT; k++) {
        pc_free(ctx, secants->step[k]);
        pc_free(ctx, secants->change[k]);
    }
    pc_free(ctx, secants->last_pull);
    pc_free(ctx, secants->last_step);
    *secants = (pc_secants){0};
}

void pc_secants_forget(pc_secants *secants) {
    secants->count = 0;
    secants->has_last = false;
}

void pc_secants_learn(pc_secants *secants, const double *pull) {
    const double weak = 1e-6; /* against the lengths: nothing is learnt where the energy hardly bends */
    const size_t n = secants->length;
    const int at = (secants->newest + 1) % PC_SECANTS_KEPT;
    double *step = secants->step[at], *change = secants->change[at];
    if (!secants->has_last) return;
    for (size_t i = 0; i < n; i++)
        change[i] = secants->last_pull[i] - pull[i];
    memcpy(step, secants->last_step, n * sizeof *step);
    const double product = pc_hostvec_dot(step, change, n);
    const double steps = pc_hostvec_dot(step, step, n), changes = pc_hostvec_dot(change, change, n);
    if (!(product > 0 && product * product > weak * weak * steps * changes)) return;
    secants->product[at] = product;
    secants->newest = at;
    if (secants->count < PC_SECANTS_KEPT) secants->count++;
}

/* The k-th newest pair. */
static int pair(const pc_secants *secants, int k) {
    return (secants->newest - k + PC_SECANTS_KEPT) % PC_SECANTS_KEPT;
}

void pc_secants_before(pc_secants *secants, double *pull) {
    const size_t n = secants->length;
    for (int k = 0; k < secants->count; k++) {
        const int at = pair(secants, k);
        secants->share[at] = pc_hostvec_dot(secants->step[at], pull, n) / secants->product[at];
        for (size_t i = 0; i < n; i++)
            pull[i] -= secants->share[at] * secants->change[at][i];
    }
}

void pc_secants_after(const pc_secants *secants, double *step) {
    const size_t n = secants->length;
    for (int k = secants->count; k-- > 0;) {
        const int at = pair(secants, k);
        const double share =
            secants->share[at] - pc_hostvec_dot(secants->change[at], step, n) / secants->product[at];
        for (size_t i = 0; i < n; i++)
            step[i] += share * secants->step[at][i];
    }
}

void pc_secants_take(pc_secants *secants, const double *step, const double *pull) {
    memcpy(secants->last_step, step, secants->length * sizeof *step);
    memcpy(secants->last_pull, pull, secants->length * sizeof *pull);
    secants->has_last = true;
}
