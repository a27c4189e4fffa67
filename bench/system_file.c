#include "system_file.h"
#include <stdio.h>

typedef struct piece {
    void *data;
    size_t bytes;
} piece;

static int pieces(piece out[5], const pc_system *s) {
    size_t n = s->row_count, entries = s->start[n], width = (size_t)pc_block_width(s->kind);
    out[0] = (piece){s->start, (n + 1) * sizeof *s->start};
    out[1] = (piece){s->column, entries * sizeof *s->column};
    out[2] = (piece){s->diagonal, n * sizeof *s->diagonal};
    out[3] = (piece){s->value, width * entries * sizeof *s->value};
    out[4] = (piece){s->turn, entries};
    return s->kind == PC_BLOCK_TURNED ? 5 : 4;
}

pc_status pc_system_save(const pc_system *system, pc_context *ctx, const char *path) {
    const uint32_t head[4] = {(uint32_t)system->kind, system->row_count, system->start[system->row_count], 0};
    piece part[5];
    int count = pieces(part, system);
    FILE *file = fopen(path, "wb");
    bool good = file && fwrite(head, sizeof head, 1, file) == 1;
    for (int k = 0; k < count && good; k++)
        good = fwrite(part[k].data, 1, part[k].bytes, file) == part[k].bytes;
    if (file && fclose(file) != 0) good = false;
    return good ? PC_OK : pc_fail(ctx, PC_E_IO, "cannot write %s", path);
}

pc_status pc_system_load(pc_system *system, pc_context *ctx, const char *path) {
    pc_status status = PC_OK;
    uint32_t head[4];
    piece part[5];
    FILE *file = fopen(path, "rb");
    *system = (pc_system){0};
    bool good = file && fread(head, sizeof head, 1, file) == 1;
    if (good) {
        PC_TRY(pc_system_make(system, ctx, (pc_block_kind)head[0], head[1], head[2]));
        system->start[head[1]] = head[2];
        int count = pieces(part, system);
        for (int k = 0; k < count && good; k++)
            good = fread(part[k].data, 1, part[k].bytes, file) == part[k].bytes;
    }
    if (!good) status = pc_fail(ctx, PC_E_IO, "cannot read %s", path);
done:
    if (file) (void)fclose(file);
    if (status != PC_OK) pc_system_free(system, ctx);
    return status;
}
