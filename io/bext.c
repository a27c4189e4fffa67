#include "bext.h"
#include "extraction.h"
#include "growing.h"
#include "textout.h"
#include <math.h>
#include <string.h>

enum { INTEGERS = 10, REALS = 5, LARGEST = 9999999 };

/* Coefficient vectors, each once, found by an open hash table. */
typedef struct vectors {
    double (*c)[16];
    pc_index count;
    size_t room;
    pc_index *slot;     /* PC_NONE: free */
    size_t slots;       /* a power of two */
    pc_index *of_point; /* per point of the basis */
} vectors;

static size_t hash_of(const double c[16]) {
    uint64_t h = 14695981039346656037u, bits;
    for (int i = 0; i < 16; i++) {
        memcpy(&bits, c + i, sizeof bits);
        h = (h ^ bits) * 1099511628211u;
        h ^= h >> 29;
    }
    return (size_t)h;
}

static bool equal(const double a[16], const double b[16]) {
    int i = 0;
    while (i < 16 && a[i] == b[i])
        i++;
    return i == 16;
}

static void place(vectors *v, pc_index number) {
    size_t at = hash_of(v->c[number]) & (v->slots - 1);
    while (v->slot[at] != PC_NONE)
        at = (at + 1) & (v->slots - 1);
    v->slot[at] = number;
}

static pc_status rehash(vectors *v, pc_context *ctx) {
    pc_status status = PC_OK;
    v->slots = v->slots ? 2 * v->slots : 1024;
    PC_TRY(pc_resize(&v->slot, ctx, v->slots));
    memset(v->slot, 0xff, v->slots * sizeof *v->slot);
    for (pc_index i = 0; i < v->count; i++)
        place(v, i);
done:
    return status;
}

static pc_status number_vector(vectors *v, pc_context *ctx, const double c[16], pc_index *number) {
    pc_status status = PC_OK;
    if (2 * (size_t)v->count >= v->slots) PC_TRY(rehash(v, ctx));
    size_t at = hash_of(c) & (v->slots - 1);
    for (; v->slot[at] != PC_NONE; at = (at + 1) & (v->slots - 1))
        if (equal(v->c[v->slot[at]], c)) {
            *number = v->slot[at];
            return PC_OK;
        }
    PC_GROW(v->c, (size_t)v->count, v->room, 1);
    memcpy(v->c[v->count], c, sizeof *v->c);
    v->slot[at] = v->count;
    *number = v->count++;
done:
    return status;
}

static pc_status collect(vectors *v, pc_context *ctx, const pc_basis *basis) {
    pc_status status = PC_OK;
    double c[16];
    PC_TRY(pc_new(&v->of_point, ctx, basis->start[basis->element_count]));
    for (pc_index e = 0; e < basis->element_count; e++)
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            pc_basis_coefficients(c, basis, e, k);
            for (int i = 0; i < 16; i++)
                if (fabs(c[i]) < 1e-99) c[i] = 0;
            PC_TRY(number_vector(v, ctx, c, v->of_point + k));
        }
done:
    return status;
}

static void put_real(pc_textout *out, double x) {
    char text[PC_DECIMAL_SPACE];
    (void)pc_decimal_write(text, fabs(x) < 1e-99 ? 0 : x);
    pc_textout_put(out, "%24s", text);
}

static void put_patch(pc_textout *out, const pc_tspline *spline, const pc_extraction *extraction,
                      const vectors *v) {
    pc_textout_put(out, "B E X T 2.0\n%8d%8u%8u%8u%8d\n", 1, extraction->node_count,
                   spline->basis.element_count, v->count, 0);
    for (pc_index i = 0; i < extraction->node_count; i++) {
        for (int k = 0; k < 3; k++)
            put_real(out, spline->position[3 * (size_t)extraction->vertex[i] + k]);
        put_real(out, 1);
        pc_textout_put(out, "\n");
    }
}

static size_t functions_on(const pc_basis *basis, pc_index e) {
    return basis->start[e + 1] - basis->start[e];
}

/* The blocks' headers, and then their elements: `blocks` counts the elements per number of functions. */
static void put_elements(pc_textout *out, const pc_basis *basis, const pc_extraction *extraction,
                         const vectors *v, const pc_index *blocks, size_t most) {
    unsigned used = 0;
    for (size_t n = 0; n <= most; n++)
        used += blocks[n] > 0;
    pc_textout_put(out, "%8u\n", used);
    for (size_t n = 0; n <= most; n++)
        if (blocks[n]) pc_textout_put(out, "%8d%8u%8zu%8zu%8d%8d\n", 1, blocks[n], n, n, 3, 3);
    for (size_t n = 0; n <= most; n++)
        for (pc_index e = 0; blocks[n] > 0 && e < basis->element_count; e++) {
            if (functions_on(basis, e) != n) continue;
            const size_t *order = extraction->order + basis->start[e];
            for (size_t k = 0; k < n; k++)
                pc_textout_put(out, "%8u%s", extraction->node[basis->point[order[k]]] + 1,
                               k % INTEGERS == INTEGERS - 1 || k + 1 == n ? "\n" : "");
            for (size_t k = 0; k < n; k++)
                pc_textout_put(out, "%8u%s", v->of_point[order[k]] + 1,
                               k % INTEGERS == INTEGERS - 1 || k + 1 == n ? "\n" : "");
        }
}

static void put_vectors(pc_textout *out, const vectors *v) {
    pc_textout_put(out, "%8d%8d\n%8u%8d\n", 1, 0, v->count, 16);
    for (pc_index i = 0; i < v->count; i++)
        for (int k = 0; k < 16; k++) {
            put_real(out, v->c[i][k]);
            if (k % REALS == REALS - 1 || k == 15) pc_textout_put(out, "\n");
        }
}

pc_status pc_bext_write(pc_context *ctx, const pc_tspline *spline, const char *path, bool force) {
    pc_status status = PC_OK;
    const pc_basis *basis = &spline->basis;
    pc_extraction extraction = {0};
    vectors v = {0};
    pc_index *blocks = NULL;
    size_t most = 0;
    pc_textout out = {0};
    PC_TRY(pc_extraction_make(&extraction, ctx, basis));
    PC_TRY(collect(&v, ctx, basis));
    if (extraction.node_count > LARGEST || basis->element_count > LARGEST || v.count > LARGEST)
        PC_TRY(pc_fail(ctx, PC_E_IO, "%s: more than %d nodes, elements or vectors do not fit the format",
                       path, LARGEST));
    for (pc_index e = 0; e < basis->element_count; e++)
        if (functions_on(basis, e) > most) most = functions_on(basis, e);
    PC_TRY(pc_new(&blocks, ctx, most + 1));
    for (pc_index e = 0; e < basis->element_count; e++)
        blocks[functions_on(basis, e)]++;
    PC_TRY(pc_textout_open(&out, ctx, path, force));
    put_patch(&out, spline, &extraction, &v);
    put_elements(&out, basis, &extraction, &v, blocks, most);
    put_vectors(&out, &v);
done:
    pc_extraction_free(&extraction, ctx);
    pc_free(ctx, blocks);
    pc_free(ctx, v.c);
    pc_free(ctx, v.slot);
    pc_free(ctx, v.of_point);
    return pc_textout_close(&out, status);
}
