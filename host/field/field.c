#include "field.h"
#include "memory.h"

void pc_field_free(pc_field *field, pc_context *ctx) {
    if (!field) return;
    pc_free(ctx, field->normal);
    pc_free(ctx, field->direction);
    pc_free(ctx, field->index);
    pc_free(ctx, field->loop_index);
    *field = (pc_field){0};
}
