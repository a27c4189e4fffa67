/* Built once per reader: FUZZ_READER is its function. */
#include "fuzz_target.h"
#include "memory.h"
#include "obj.h"
#include "off.h"
#include "ply.h"
#include "scan.h"
#include "stl.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void demand(int fact, const char *what) {
    if (fact) return;
    (void)fprintf(stderr, "the reader broke its word: %s\n", what);
    abort();
}

static void check_mesh(const pc_mesh *mesh) {
    demand(mesh->vertex_count > 0 && mesh->face_count > 0, "an empty mesh");
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
        demand(isfinite(mesh->position[i]), "a coordinate that is not finite");
    for (size_t i = 0; i < 3 * (size_t)mesh->face_count; i++)
        demand(mesh->triangle[i] < mesh->vertex_count, "an index out of range");
}

#ifdef FUZZ_SCAN
static pc_status read_any(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input) {
    return pc_scan_read_bytes(mesh, info, ctx, input->name, input->data, input->size);
}
#define FUZZ_READER read_any
#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    pc_context *ctx = pc_context_make();
    if (!ctx) return 0;
    pc_mesh mesh = {0};
    pc_scan_info info = {0};
    pc_scan_input input = {.name = "fuzz", .data = (const char *)data, .size = size};
    pc_status status = FUZZ_READER(&mesh, &info, ctx, &input);
    demand(pc_memory_peak(ctx) <= 1200 * size + (4 << 20), "far more memory than the file is long");
    if (status == PC_OK)
        check_mesh(&mesh);
    else
        demand(status == PC_E_FORMAT && *pc_context_message(ctx) && !mesh.position && !mesh.triangle,
               "a failure without a message, or with half a mesh");
    pc_mesh_free(&mesh, ctx);
    demand(pc_memory_used(ctx) == 0, "memory left behind");
    pc_context_free(ctx);
    return 0;
}
