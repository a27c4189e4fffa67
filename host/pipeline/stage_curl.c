#include "memory.h"
#include "stage.h"
static bool wanted(const pc_convert_options *options) {
    return options->curl_correction;
}
static void drop(pc_run *run) {
    pc_free(run->ctx, run->product.scale);
}
const pc_stage pc_stage_curl = {.name = "curl",
                                .version = 1,
                                .wanted = wanted,
                                .drop = drop,
                                .needs = PC_NEEDS(PC_STAGE_MESH) | PC_NEEDS(PC_STAGE_FIELD)};
