#include "layout.h"
#include "memory.h"

void pc_layout_free(pc_layout *layout, pc_context *ctx) {
    if (!layout) return;
    pc_mesh_free(&layout->mesh, ctx);
    pc_free(ctx, layout->source_face);
    pc_free(ctx, layout->cell);
    pc_free(ctx, layout->node_vertex);
    pc_free(ctx, layout->arc_start);
    pc_free(ctx, layout->arc_vertex);
    pc_free(ctx, layout->arc_node);
    pc_free(ctx, layout->arc_cell);
    pc_free(ctx, layout->cell_start);
    pc_free(ctx, layout->cell_side);
    pc_free(ctx, layout->cell_side_flat);
    *layout = (pc_layout){0};
}
