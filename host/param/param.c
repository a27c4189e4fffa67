#include "param.h"
#include "memory.h"

void pc_param_free(pc_param *param, pc_context *ctx) {
    if (!param) return;
    pc_free(ctx, param->phase);
    pc_free(ctx, param->coordinate);
    pc_free(ctx, param->turn);
    pc_free(ctx, param->shift);
    pc_free(ctx, param->singular);
    *param = (pc_param){0};
}
