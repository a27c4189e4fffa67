#include "iga.h"
#include "extraction.h"
#include "textout.h"

static void put_nodes(pc_textout *out, const pc_tspline *spline, const pc_extraction *extraction) {
    for (pc_index i = 0; i < extraction->node_count; i++) {
        pc_textout_put(out, "node ");
        pc_textout_reals(out, spline->position + 3 * (size_t)extraction->vertex[i], 3);
        pc_textout_put(out, " 1\n");
    }
}

static void put_element(pc_textout *out, const pc_basis *basis, const pc_extraction *extraction, pc_index e) {
    size_t start = basis->start[e], end = basis->start[e + 1];
    pc_textout_put(out, "belem %zu 3 3\n", end - start);
    for (size_t k = start; k < end; k++)
        pc_textout_put(out, k > start ? " %u" : "%u", extraction->node[basis->point[extraction->order[k]]]);
    for (size_t k = start; k < end; k++) {
        double c[16];
        pc_basis_coefficients(c, basis, e, extraction->order[k]);
        pc_textout_put(out, "\n");
        pc_textout_reals(out, c, 16);
    }
    pc_textout_put(out, "\n");
}

pc_status pc_iga_write(pc_context *ctx, const pc_tspline *spline, const char *path, bool force) {
    pc_status status = PC_OK;
    const pc_basis *basis = &spline->basis;
    pc_extraction extraction = {0};
    pc_textout out = {0};
    PC_TRY(pc_extraction_make(&extraction, ctx, basis));
    PC_TRY(pc_textout_open(&out, ctx, path, force));
    pc_textout_put(&out, "type surface\nnodeN %u\nelemN %u\n", extraction.node_count, basis->element_count);
    put_nodes(&out, spline, &extraction);
    for (pc_index e = 0; e < basis->element_count; e++)
        put_element(&out, basis, &extraction, e);
done:
    pc_extraction_free(&extraction, ctx);
    return pc_textout_close(&out, status);
}
