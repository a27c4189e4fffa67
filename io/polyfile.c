#include "polyfile.h"
#include "decimal.h"
#include "file.h"
#include "memory.h"
#include <stdio.h>
#include <string.h>

/* Polygons, or triangles where `start` is NULL. */
typedef struct view {
    size_t vertex_count, face_count;
    const double *position;
    const pc_index *start;
    const pc_index *corner;
} view;

static view of_polygons(const pc_polymesh *mesh) {
    return (view){mesh->vertex_count, mesh->face_count, mesh->position, mesh->start, mesh->corner};
}

static view of_triangles(const pc_mesh *mesh) {
    return (view){mesh->vertex_count, mesh->face_count, mesh->position, NULL, mesh->triangle};
}

static size_t start_of(const view *v, size_t face) {
    return v->start ? v->start[face] : 3 * face;
}

/* ---- OBJ ---- */

enum { BLOCK = 4096, BLOCKS = 16, LINE = 3 * PC_DECIMAL_SPACE + 8 };

static size_t vertex_line(char *text, const double *p) {
    char *at = text;
    *at++ = 'v';
    for (int k = 0; k < 3; k++) {
        *at++ = ' ';
        at += pc_decimal_write(at, p[k]);
    }
    *at++ = '\n';
    return (size_t)(at - text);
}

/* Blocks are made into text side by side and written in their order. */
static pc_status write_vertex_lines(pc_writer *writer, pc_context *ctx, const view *v) {
    pc_status status = PC_OK;
    char *text = NULL;
    size_t used[BLOCKS];
    PC_TRY(pc_resize_bytes((void **)&text, ctx, (size_t)BLOCKS * BLOCK, LINE));
    for (size_t first = 0; first < v->vertex_count; first += (size_t)BLOCKS * BLOCK) {
#pragma omp parallel for schedule(static, 1)
        for (size_t b = 0; b < BLOCKS; b++) {
            char *begin = text + b * BLOCK * LINE;
            char *at = begin;
            size_t end = first + (b + 1) * BLOCK;
            for (size_t i = first + b * BLOCK; i < end && i < v->vertex_count; i++)
                at += vertex_line(at, v->position + 3 * i);
            used[b] = (size_t)(at - begin);
        }
        for (size_t b = 0; b < BLOCKS; b++)
            PC_TRY(pc_writer_put(writer, text + b * BLOCK * LINE, used[b]));
        PC_TRY(pc_check_interrupt(ctx));
    }
done:
    pc_free(ctx, text);
    return status;
}

static size_t write_integer(char *text, size_t value) {
    char digits[24];
    size_t n = 0;
    do
        digits[n++] = (char)('0' + value % 10);
    while ((value /= 10) != 0);
    for (size_t i = 0; i < n; i++)
        text[i] = digits[n - 1 - i];
    return n;
}

static pc_status write_face_lines(pc_writer *writer, pc_context *ctx, const view *v) {
    pc_status status = PC_OK;
    for (size_t f = 0; f < v->face_count; f++) {
        PC_TRY(pc_writer_put(writer, "f", 1));
        for (size_t c = start_of(v, f); c < start_of(v, f + 1); c++) {
            char text[32] = " ";
            PC_TRY(pc_writer_put(writer, text, 1 + write_integer(text + 1, (size_t)v->corner[c] + 1)));
        }
        PC_TRY(pc_writer_put(writer, "\n", 1));
        if (f % 65536 == 0) PC_TRY(pc_check_interrupt(ctx));
    }
done:
    return status;
}

static pc_status write_obj(pc_context *ctx, const view *v, const char *path, bool force) {
    pc_status status = PC_OK;
    pc_writer writer = {0};
    char head[96];
    int n =
        snprintf(head, sizeof head, "# Percale: %zu vertices, %zu faces\n", v->vertex_count, v->face_count);
    PC_TRY(pc_writer_open(&writer, ctx, path, force));
    PC_TRY(pc_writer_put(&writer, head, (size_t)n));
    PC_TRY(write_vertex_lines(&writer, ctx, v));
    PC_TRY(write_face_lines(&writer, ctx, v));
    PC_TRY(pc_writer_commit(&writer));
done:
    pc_writer_abandon(&writer);
    return status;
}

/* ---- PLY ---- */

static void store_little(char *at, uint64_t bits, size_t size) {
    for (size_t i = 0; i < size; i++)
        at[i] = (char)(unsigned char)(bits >> (8 * i));
}

static size_t most_sides(const view *v) {
    size_t most = 3;
    for (size_t f = 0; v->start && f < v->face_count; f++)
        if (v->start[f + 1] - v->start[f] > most) most = v->start[f + 1] - v->start[f];
    return most;
}

static pc_status write_vertex_records(pc_writer *writer, pc_context *ctx, const view *v) {
    pc_status status = PC_OK;
    for (size_t i = 0; i < v->vertex_count; i++) {
        char record[24];
        for (size_t k = 0; k < 3; k++) {
            uint64_t bits;
            memcpy(&bits, &v->position[3 * i + k], sizeof bits);
            store_little(record + 8 * k, bits, 8);
        }
        PC_TRY(pc_writer_put(writer, record, sizeof record));
        if (i % 65536 == 0) PC_TRY(pc_check_interrupt(ctx));
    }
done:
    return status;
}

static pc_status write_face_records(pc_writer *writer, pc_context *ctx, const view *v, size_t count_size) {
    pc_status status = PC_OK;
    for (size_t f = 0; f < v->face_count; f++) {
        char item[8];
        size_t end = start_of(v, f + 1);
        store_little(item, end - start_of(v, f), count_size);
        PC_TRY(pc_writer_put(writer, item, count_size));
        for (size_t c = start_of(v, f); c < end; c++) {
            store_little(item, v->corner[c], 4);
            PC_TRY(pc_writer_put(writer, item, 4));
        }
        if (f % 65536 == 0) PC_TRY(pc_check_interrupt(ctx));
    }
done:
    return status;
}

/* The types that most programs know, as long as the numbers fit into them. */
static pc_status write_ply(pc_context *ctx, const view *v, const char *path, bool force) {
    pc_status status = PC_OK;
    pc_writer writer = {0};
    char head[320];
    bool few = most_sides(v) < 256;
    bool fits = v->vertex_count <= INT32_MAX;
    int n = snprintf(head, sizeof head,
                     "ply\nformat binary_little_endian 1.0\ncomment Percale\nelement vertex %zu\n"
                     "property double x\nproperty double y\nproperty double z\nelement face %zu\n"
                     "property list %s %s vertex_indices\nend_header\n",
                     v->vertex_count, v->face_count, few ? "uchar" : "uint", fits ? "int" : "uint");
    PC_TRY(pc_writer_open(&writer, ctx, path, force));
    PC_TRY(pc_writer_put(&writer, head, (size_t)n));
    PC_TRY(write_vertex_records(&writer, ctx, v));
    PC_TRY(write_face_records(&writer, ctx, v, few ? 1 : 4));
    PC_TRY(pc_writer_commit(&writer));
done:
    pc_writer_abandon(&writer);
    return status;
}

pc_status pc_polyfile_write_obj(pc_context *ctx, const pc_polymesh *mesh, const char *path, bool force) {
    const view v = of_polygons(mesh);
    return write_obj(ctx, &v, path, force);
}

pc_status pc_polyfile_write_ply(pc_context *ctx, const pc_polymesh *mesh, const char *path, bool force) {
    const view v = of_polygons(mesh);
    return write_ply(ctx, &v, path, force);
}

pc_status pc_polyfile_write_mesh_obj(pc_context *ctx, const pc_mesh *mesh, const char *path, bool force) {
    const view v = of_triangles(mesh);
    return write_obj(ctx, &v, path, force);
}

pc_status pc_polyfile_write_mesh_ply(pc_context *ctx, const pc_mesh *mesh, const char *path, bool force) {
    const view v = of_triangles(mesh);
    return write_ply(ctx, &v, path, force);
}
