#include "off.h"
#include "decimal.h"
#include "facelist.h"
#include "memory.h"
#include "textcursor.h"
#include "triangulate.h"

typedef struct off_reader {
    pc_mesh *mesh;
    pc_scan_info *info;
    pc_context *ctx;
    const pc_scan_input *input;
    pc_textcursor text;
    int64_t vertices, faces;
    pc_facelist list;
    pc_index *corner;
    size_t corner_room;
} off_reader;

#define FAIL(r, at_, ...)                                                                                    \
    pc_scan_fail_line((r)->ctx, (r)->input, (size_t)((at_) - (r)->input->data), __VA_ARGS__)

/* [ST][C][N][4][n]OFF; the digits and letters before it say what stands on a vertex's line. */
static pc_status read_keyword(off_reader *r) {
    const char *at = r->text.at;
    const char *end = pc_word_end(&r->text);
    if (end - at < 3 || memcmp(end - 3, "OFF", 3) != 0) return PC_OK; /* some writers leave it out */
    for (const char *p = at; p < end - 3; p++) {
        if (*p == 'S' && p[1] == 'T')
            pc_scan_ignore(r->info, "texture coordinates"), p++;
        else if (*p == 'C')
            pc_scan_ignore(r->info, "colours");
        else if (*p == 'N')
            pc_scan_ignore(r->info, "normals");
        else
            return FAIL(r, at, "%s is a variant of OFF that is not read here: convert it to PLY",
                        pc_scan_quote(at, end).text);
    }
    r->text.at = end;
    pc_skip_blanks(&r->text);
    if (pc_word_is(r->text.at, pc_word_end(&r->text), "BINARY"))
        return FAIL(r, at, "binary OFF is not read here: convert it to PLY");
    return PC_OK;
}

static pc_status read_count(int64_t *count, off_reader *r, const char *what) {
    if (!pc_skip_comments(&r->text))
        return FAIL(r, r->text.at, "the file ends before the number of %s", what);
    const char *at = r->text.at;
    if (!pc_decimal_read_integer(count, &r->text.at, r->text.end) || !pc_at_word_end(&r->text) || *count < 0)
        return FAIL(r, at, "'%s' is not a number of %s", pc_scan_quote(at, r->text.end).text, what);
    return PC_OK;
}

static pc_status read_counts(off_reader *r) {
    pc_status status = PC_OK;
    if (!pc_skip_comments(&r->text)) return FAIL(r, r->text.at, "the file is empty");
    PC_TRY(read_keyword(r));
    PC_TRY(read_count(&r->vertices, r, "vertices"));
    PC_TRY(read_count(&r->faces, r, "faces"));
    const char *at = r->text.at;
    pc_skip_line(&r->text); /* the number of edges: nobody needs it, some leave it out */
    int64_t left = r->text.end - r->text.at;
    /* "0 0 0\n" is the shortest vertex, "0\n" the shortest face; the last newline may be missing. */
    if (r->vertices > (left + 1) / 6 || r->faces > (left + 1 - 6 * r->vertices) / 2)
        return FAIL(
            r, at,
            "%lld vertices and %lld faces do not fit into the %lld bytes left: the file is truncated or "
            "the counts are wrong; get it anew",
            (long long)r->vertices, (long long)r->faces, (long long)left);
done:
    return status;
}

static pc_status read_vertex(off_reader *r, size_t vertex) {
    double *position = r->mesh->position + 3 * vertex;
    for (int k = 0; k < 3; k++) {
        if (k == 0 ? !pc_skip_comments(&r->text) : pc_at_line_end(&r->text))
            return FAIL(r, r->text.at, "vertex %zu: %s", vertex,
                        r->text.at == r->text.end ? "the file ends here: it is truncated, get it anew"
                                                  : "fewer than three coordinates");
        const char *at = r->text.at;
        pc_decimal_result result = pc_decimal_read(&position[k], &r->text.at, r->text.end);
        if (result == PC_DECIMAL_NOT_FINITE)
            return FAIL(r, at, "vertex %zu: '%s': a coordinate is not a finite number: remove this vertex",
                        vertex, pc_scan_quote(at, r->text.end).text);
        if (result == PC_DECIMAL_NONE || !pc_at_word_end(&r->text))
            return FAIL(r, at, "vertex %zu: '%s' is not a number", vertex,
                        pc_scan_quote(at, r->text.end).text);
    }
    if (!pc_at_line_end(&r->text) && !*r->info->ignored)
        pc_scan_ignore(r->info, "more values on vertex lines");
    pc_skip_line(&r->text);
    return PC_OK;
}

static pc_status corner_room(off_reader *r, size_t sides) {
    if (sides <= r->corner_room) return PC_OK;
    pc_status status = pc_resize(&r->corner, r->ctx, sides + sides / 2);
    if (status == PC_OK) r->corner_room = sides + sides / 2;
    return status;
}

static pc_status read_corners(off_reader *r, size_t face, size_t sides) {
    for (size_t k = 0; k < sides; k++) {
        int64_t index;
        if (pc_at_line_end(&r->text))
            return FAIL(r, r->text.at, "face %zu: %s", face,
                        r->text.at == r->text.end ? "the file ends here: it is truncated, get it anew"
                                                  : "fewer corners than its count says");
        const char *at = r->text.at;
        if (!pc_decimal_read_integer(&index, &r->text.at, r->text.end) || !pc_at_word_end(&r->text))
            return FAIL(r, at, "face %zu: '%s' is not a vertex index", face,
                        pc_scan_quote(at, r->text.end).text);
        if (index < 0 || index >= r->vertices)
            return FAIL(r, at, "face %zu: vertex index %lld is not one of the %lld vertices", face,
                        (long long)index, (long long)r->vertices);
        r->corner[k] = (pc_index)index;
    }
    return PC_OK;
}

static pc_status read_face(off_reader *r, size_t face) {
    pc_status status = PC_OK;
    int64_t sides;
    if (!pc_skip_comments(&r->text))
        return FAIL(r, r->text.at, "face %zu of %lld: the file ends here: it is truncated, get it anew", face,
                    (long long)r->faces);
    const char *at = r->text.at;
    if (!pc_decimal_read_integer(&sides, &r->text.at, r->text.end) || !pc_at_word_end(&r->text) || sides < 0)
        return FAIL(r, at, "face %zu: '%s' is not a number of corners", face,
                    pc_scan_quote(at, r->text.end).text);
    if (sides > PC_CUTTER_LIMIT)
        return FAIL(r, at, "face %zu: %lld corners are more than %d: cut the face into smaller ones", face,
                    (long long)sides, PC_CUTTER_LIMIT);
    PC_TRY(corner_room(r, (size_t)sides));
    PC_TRY(read_corners(r, face, (size_t)sides));
    if (!pc_at_line_end(&r->text)) pc_scan_ignore(r->info, "face colours");
    pc_skip_line(&r->text);
    r->info->short_face_count += sides < 3;
    r->info->polygon_count += sides > 3;
    if (sides >= 3) PC_TRY(pc_facelist_add(&r->list, r->ctx, r->corner, (size_t)sides));
done:
    return status;
}

static pc_status read_all(off_reader *r) {
    pc_status status = PC_OK;
    PC_TRY(read_counts(r));
    PC_TRY(pc_scan_make_vertices(r->mesh, r->ctx, r->input, (size_t)r->vertices));
    PC_TRY(pc_facelist_reserve(&r->list, r->ctx, (size_t)r->faces));
    for (size_t i = 0; i < (size_t)r->vertices; i++) {
        if (i % 65536 == 0) PC_TRY(pc_check_interrupt(r->ctx));
        PC_TRY(read_vertex(r, i));
    }
    for (size_t i = 0; i < (size_t)r->faces; i++) {
        if (i % 65536 == 0) PC_TRY(pc_check_interrupt(r->ctx));
        PC_TRY(read_face(r, i));
    }
    r->info->vertex_count = (size_t)r->vertices;
    r->info->face_count = (size_t)r->faces;
    r->mesh->face_count = (pc_index)r->list.count;
    PC_TRY(pc_scan_check_counts(r->mesh, r->ctx, r->input, pc_scan_fail_line));
    PC_TRY(pc_facelist_finish(&r->list, r->ctx, r->mesh));
done:
    return status;
}

pc_status pc_off_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input) {
    off_reader r = {.mesh = mesh, .info = info, .ctx = ctx, .input = input};
    r.text = (pc_textcursor){input->data, input->data + input->size};
    *mesh = (pc_mesh){0};
    info->format = "OFF";
    pc_status status = read_all(&r);
    pc_facelist_free(&r.list, ctx);
    pc_free(ctx, r.corner);
    if (status != PC_OK) pc_mesh_free(mesh, ctx);
    return status;
}
