#include "stl.h"
#include "decimal.h"
#include "facelist.h"
#include "memory.h"
#include "textcursor.h"
#include "weld.h"
#include <math.h>

enum { HEADER = 84, RECORD = 50, BATCH = 64 };

typedef struct stl_reader {
    pc_context *ctx;
    const pc_scan_input *input;
    pc_textcursor text;
    pc_facelist faces;
    pc_weld weld;
    size_t facet;
} stl_reader;

static uint32_t load_word(const char *at) {
    const unsigned char *p = (const unsigned char *)at;
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static double load_float(const char *at) {
    uint32_t word = load_word(at);
    float value;
    memcpy(&value, &word, sizeof value);
    return (double)value;
}

static bool has_word(const char *at, size_t size, const char *word) {
    size_t n = strlen(word);
    for (size_t i = 0; i + n <= size; i++) {
        size_t k = 0;
        while (k < n && (at[i + k] | 0x20) == word[k])
            k++;
        if (k == n) return true;
    }
    return false;
}

bool pc_stl_is_binary(const char *data, size_t size) {
    if (size >= HEADER && (size - HEADER) % RECORD == 0 && (size - HEADER) / RECORD == load_word(data + 80))
        return true;
    pc_textcursor c = {data, data + size};
    pc_skip_spaces(&c);
    size_t left = (size_t)(c.end - c.at);
    if (left < 5 || !has_word(c.at, 5, "solid")) return true;
    if (left > 4096) left = 4096;
    return memchr(c.at, 0, left) || !(has_word(c.at, left, "facet") || has_word(c.at, left, "endsolid"));
}

/* ---- binary ---- */

static pc_status fail_not_finite(stl_reader *r, const double *point, size_t first, size_t count) {
    for (size_t i = 0; i < 3 * count; i++)
        if (!isfinite(point[i])) {
            size_t facet = first + i / 9;
            return pc_scan_fail_byte(r->ctx, r->input, HEADER + RECORD * facet + 12 + 4 * (i % 9),
                                     "facet %zu: a coordinate is not a finite number: remove this facet",
                                     facet);
        }
    return PC_OK;
}

static pc_status read_binary(stl_reader *r) {
    pc_status status = PC_OK;
    double point[9 * BATCH];
    const pc_scan_input *input = r->input;
    if (input->size < HEADER)
        return pc_scan_fail_byte(r->ctx, input, input->size,
                                 "the file ends within the header of a binary STL");
    size_t count = load_word(input->data + 80);
    size_t there = (input->size - HEADER) / RECORD;
    if (count > there)
        return pc_scan_fail_byte(
            r->ctx, input, 80,
            "the header promises %zu facets of 50 bytes, but the file ends after facet %zu: it is "
            "truncated or the count is wrong; get it anew",
            count, there);
    if ((input->size - HEADER) > count * RECORD)
        pc_log(r->ctx, PC_LOG_WARNING, "%s: %zu bytes behind the last facet are ignored", input->name,
               input->size - HEADER - count * RECORD);
    PC_TRY(pc_facelist_reserve(&r->faces, r->ctx, count));
    for (size_t f = 0; f < count; f += BATCH) {
        size_t n = count - f < BATCH ? count - f : BATCH;
        for (size_t i = 0; i < n; i++)
            for (size_t k = 0; k < 9; k++)
                point[9 * i + k] = load_float(input->data + HEADER + RECORD * (f + i) + 12 + 4 * k);
        PC_TRY(fail_not_finite(r, point, f, 3 * n));
        PC_TRY(pc_weld_add(&r->weld, r->ctx, r->faces.triangle + 3 * f, point, 3 * n));
        if (f % (BATCH * 1024) == 0) PC_TRY(pc_check_interrupt(r->ctx));
    }
    r->faces.count = count;
done:
    return status;
}

/* ---- ascii ---- */

#define FAIL(r, at_, ...)                                                                                    \
    pc_scan_fail_line((r)->ctx, (r)->input, (size_t)((at_) - (r)->input->data), __VA_ARGS__)

static bool take_word(stl_reader *r, const char *word) {
    pc_skip_spaces(&r->text);
    const char *end = pc_word_end(&r->text);
    size_t n = strlen(word);
    if ((size_t)(end - r->text.at) != n || !has_word(r->text.at, n, word)) return false;
    r->text.at = end;
    return true;
}

static pc_status fail_word(stl_reader *r, const char *wanted) {
    if (r->text.at == r->text.end)
        return FAIL(r, r->text.at,
                    "facet %zu: the file ends here, where '%s' should stand: it is truncated, get it anew",
                    r->facet, wanted);
    return FAIL(r, r->text.at, "facet %zu: '%s' stands where '%s' should", r->facet,
                pc_scan_quote(r->text.at, r->text.end).text, wanted);
}

static pc_status read_corner(stl_reader *r, double *point) {
    if (!take_word(r, "vertex")) return fail_word(r, "vertex");
    for (int k = 0; k < 3; k++) {
        pc_skip_blanks(&r->text);
        const char *at = r->text.at;
        pc_decimal_result result = pc_decimal_read(&point[k], &r->text.at, r->text.end);
        if (result == PC_DECIMAL_NOT_FINITE)
            return FAIL(r, at, "facet %zu: '%s': a coordinate is not a finite number: remove this facet",
                        r->facet, pc_scan_quote(at, r->text.end).text);
        if (result == PC_DECIMAL_NONE || !pc_at_word_end(&r->text)) {
            r->text.at = at;
            return at == r->text.end ? fail_word(r, "a number")
                                     : FAIL(r, at, "facet %zu: '%s' is not a number", r->facet,
                                            pc_scan_quote(at, r->text.end).text);
        }
    }
    return PC_OK;
}

static pc_status read_facet(stl_reader *r) {
    pc_status status = PC_OK;
    double point[9];
    pc_index corner[3];
    pc_skip_line(&r->text); /* the normal */
    if (!take_word(r, "outer") || !take_word(r, "loop")) return fail_word(r, "outer loop");
    for (int k = 0; k < 3; k++)
        PC_TRY(read_corner(r, point + 3 * k));
    if (!take_word(r, "endloop")) return fail_word(r, "endloop");
    if (!take_word(r, "endfacet")) return fail_word(r, "endfacet");
    PC_TRY(pc_weld_add(&r->weld, r->ctx, corner, point, 3));
    PC_TRY(pc_facelist_add(&r->faces, r->ctx, corner, 3));
done:
    return status;
}

/* One solid after the other; their names take the rest of the line. */
static pc_status read_ascii(stl_reader *r) {
    pc_status status = PC_OK;
    bool inside = false;
    for (;;) {
        pc_skip_spaces(&r->text);
        if (!inside && r->text.at == r->text.end) break;
        if (!inside && take_word(r, "solid")) {
            pc_skip_line(&r->text);
            inside = true;
        } else if (inside && take_word(r, "endsolid")) {
            pc_skip_line(&r->text);
            inside = false;
        } else if (inside && take_word(r, "facet")) {
            PC_TRY(read_facet(r));
            if (++r->facet % 65536 == 0) PC_TRY(pc_check_interrupt(r->ctx));
        } else {
            return fail_word(r, inside ? "facet or endsolid" : "solid");
        }
    }
done:
    return status;
}

static pc_status finish(stl_reader *r, pc_mesh *mesh, pc_scan_info *info) {
    pc_status status = PC_OK;
    info->face_count = r->faces.count;
    info->vertex_count = 3 * r->faces.count;
    info->welded_count = 3 * r->faces.count - r->weld.count;
    mesh->vertex_count = (pc_index)r->weld.count;
    mesh->face_count = (pc_index)r->faces.count;
    if (mesh->face_count == 0)
        return pc_scan_fail_line(r->ctx, r->input, 0,
                                 "there is not a single facet in this STL: nothing to convert");
    if (r->weld.capacity - r->weld.count > r->weld.count / 8)
        PC_TRY(pc_resize_bytes((void **)&r->weld.position, r->ctx, r->weld.count, 3 * sizeof(double)));
    mesh->position = r->weld.position;
    r->weld.position = NULL;
    PC_TRY(pc_facelist_finish(&r->faces, r->ctx, mesh));
done:
    return status;
}

pc_status pc_stl_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input) {
    pc_status status = PC_OK;
    stl_reader r = {.ctx = ctx, .input = input};
    bool binary = pc_stl_is_binary(input->data, input->size);
    r.text = (pc_textcursor){input->data, input->data + input->size};
    *mesh = (pc_mesh){0};
    info->format = binary ? "STL binary" : "STL ascii";
    PC_TRY(binary ? read_binary(&r) : read_ascii(&r));
    PC_TRY(finish(&r, mesh, info));
done:
    pc_facelist_free(&r.faces, ctx);
    pc_weld_free(&r.weld, ctx);
    if (status != PC_OK) pc_mesh_free(mesh, ctx);
    return status;
}
