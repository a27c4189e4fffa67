#include "obj.h"
#include "decimal.h"
#include "facelist.h"
#include "memory.h"
#include "textcursor.h"
#include "triangulate.h"

/* The text is read in pieces of about this size, each of whole statements, whatever the number of threads. */
enum { PIECE = 1 << 20 };

typedef struct obj_error {
    const char *at; /* NULL where all is well */
    const char *what;
    const char *kind; /* "vertex" or "face" */
    size_t element;
} obj_error;

typedef struct obj_piece {
    pc_textcursor text;
    size_t vertices, faces, triangles, polygons, short_faces;
    size_t first_vertex, first_face, first_triangle, first_polygon;
    bool normals, textures, colours, others;
    obj_error error;
} obj_piece;

typedef struct obj_reader {
    pc_mesh *mesh;
    pc_context *ctx;
    const pc_scan_input *input;
    obj_piece *piece;
    size_t piece_count;
    obj_piece total;
    pc_facelist faces;
} obj_reader;

/* ---- statements and their words ---- */

static bool at_continuation(const pc_textcursor *c) {
    return *c->at == '\\' && c->at + 1 < c->end && pc_is_newline(c->at[1]);
}

/* To the next word of the statement, over backslashes at line ends; false at its end. */
static inline bool next_word(pc_textcursor *c) {
    for (;;) {
        pc_skip_blanks(c);
        if (c->at == c->end || pc_is_newline(*c->at)) return false;
        if (*c->at == '#') {
            pc_skip_line(c);
            return false;
        }
        if (!at_continuation(c)) return true;
        c->at++;
        if (*c->at == '\r' && c->at + 1 < c->end && c->at[1] == '\n') c->at++;
        c->at++;
    }
}

static inline bool in_word(const pc_textcursor *c) {
    return c->at < c->end && !pc_is_space(*c->at) && !at_continuation(c);
}

enum { LETTER, BLANK, SPECIAL };
static const unsigned char kind_of_letter[256] = {
    [' '] = BLANK,    ['\t'] = BLANK,   ['\v'] = BLANK,  ['\f'] = BLANK,
    ['\n'] = SPECIAL, ['\r'] = SPECIAL, ['#'] = SPECIAL, ['\\'] = SPECIAL};

/* Words of the statement, each passed over: as many as next_word and in_word would find, with few branches.
 */
static size_t count_words(pc_textcursor *c) {
    size_t count = 0;
    unsigned between = 1;
    for (; c->at < c->end; c->at++) {
        unsigned kind = kind_of_letter[(unsigned char)*c->at];
        if (kind == SPECIAL) {
            if (pc_is_newline(*c->at)) break;
            if ((*c->at == '#' && between) || (*c->at == '\\' && at_continuation(c))) {
                between = 1;
                if (!next_word(c)) break;
            }
            kind = LETTER;
        }
        count += between & (kind == LETTER);
        between = kind;
    }
    return count;
}

/* To the end of the line: by memchr where '\n' or "\r\n" ends it and no backslash joins the next. */
static void skip_statement(pc_textcursor *c) {
    const char *newline = memchr(c->at, '\n', (size_t)(c->end - c->at));
    const char *cr = newline ? memchr(c->at, '\r', (size_t)(newline - c->at)) : NULL;
    const char *end = cr ? cr : newline;
    if (newline && (!cr || cr == newline - 1) && end > c->at && end[-1] != '\\')
        c->at = newline;
    else
        (void)count_words(c);
}

/* The keyword at the start of a line: 'v', 'f', or another. */
static char keyword(const pc_textcursor *c) {
    if (c->end - c->at < 2 || !pc_is_blank(c->at[1])) return '\0';
    return *c->at == 'v' || *c->at == 'f' ? *c->at : '\0';
}

/* ---- first pass: how much there is ---- */

static void note_other(obj_piece *piece, const pc_textcursor *c) {
    if (*c->at == '#' || *c->at == '\\') return;
    if (c->end - c->at > 2 && c->at[0] == 'v' && c->at[1] == 'n')
        piece->normals = true;
    else if (c->end - c->at > 2 && c->at[0] == 'v' && c->at[1] == 't')
        piece->textures = true;
    else if (*c->at != 'g' && *c->at != 'o' && *c->at != 's' && *c->at != 'u' && *c->at != 'm')
        piece->others = true;
}

static void count_piece(obj_piece *piece) {
    pc_textcursor c = piece->text;
    for (;;) {
        pc_skip_spaces(&c);
        if (c.at == c.end) return;
        char word = keyword(&c);
        if (word == '\0') {
            note_other(piece, &c);
            pc_skip_line(&c);
            continue;
        }
        c.at++;
        if (word == 'v') {
            skip_statement(&c);
            piece->vertices++;
            continue;
        }
        size_t words = count_words(&c);
        piece->faces++;
        piece->triangles += words < 3 ? 0 : words - 2;
        piece->polygons += words > 3;
        piece->short_faces += words < 3;
    }
}

/* ---- second pass: the numbers ---- */

static bool fail_piece(obj_piece *piece, const char *at, const char *kind, size_t element, const char *what) {
    piece->error = (obj_error){at, what, kind, element};
    return false;
}

static bool read_vertex(obj_piece *piece, pc_textcursor *c, size_t vertex, double *position) {
    double rest;
    for (int k = 0;; k++) {
        if (!next_word(c)) {
            piece->colours |= k >= 6;
            return k >= 3 || fail_piece(piece, c->at, "vertex", vertex, "fewer than three coordinates");
        }
        const char *word = c->at;
        pc_decimal_result result = pc_decimal_read(k < 3 ? &position[k] : &rest, &c->at, c->end);
        if (result == PC_DECIMAL_NOT_FINITE && k >= 3) {
            while (in_word(c))
                c->at++;
            continue;
        }
        if (result == PC_DECIMAL_NOT_FINITE)
            return fail_piece(piece, word, "vertex", vertex,
                              "a coordinate is not a finite number: remove this vertex");
        if (result == PC_DECIMAL_NONE || in_word(c))
            return fail_piece(piece, word, "vertex", vertex, "not a number");
    }
}

static bool read_corner(pc_index *corner, obj_piece *piece, pc_textcursor *c, size_t face, size_t seen,
                        size_t total) {
    const char *word = c->at;
    int64_t index;
    int64_t other;
    if (!pc_decimal_read_integer(&index, &c->at, c->end))
        return fail_piece(piece, word, "face", face, "not a vertex index");
    for (int k = 0; k < 2 && c->at < c->end && *c->at == '/'; k++) {
        c->at++;
        (void)pc_decimal_read_integer(&other, &c->at, c->end);
    }
    if (in_word(c)) return fail_piece(piece, word, "face", face, "not a vertex index");
    if (index < 0) index += (int64_t)seen + 1;
    if (index < 1 || index > (int64_t)total)
        return fail_piece(piece, word, "face", face, "index of a vertex that does not exist");
    *corner = (pc_index)(index - 1);
    return true;
}

/* Corners straight into the fan (c0 c1 c2) (c0 c2 c3) ...; gives the number of triangles in *count. */
static bool read_face(size_t *count, pc_index *triangle, obj_piece *piece, pc_textcursor *c, size_t face,
                      size_t seen, size_t total) {
    pc_index first[3];
    size_t sides = 0;
    for (; next_word(c); sides++) {
        pc_index corner;
        if (!read_corner(&corner, piece, c, face, seen, total)) return false;
        if (sides < 2) {
            first[sides] = corner;
            continue;
        }
        pc_index *t = triangle + 3 * (sides - 2);
        t[0] = first[0];
        t[1] = sides == 2 ? first[1] : t[-1];
        t[2] = corner;
    }
    if (sides > PC_CUTTER_LIMIT)
        return fail_piece(piece, c->at, "face", face, "too many corners: cut it into smaller ones");
    if (sides < 3 && c->at == c->end)
        return fail_piece(piece, c->at, "face", face,
                          "the file ends within this face: it is truncated, get it anew");
    *count = sides < 3 ? 0 : sides - 2;
    return true;
}

static void read_piece(obj_piece *piece, pc_mesh *mesh, pc_facelist *faces, size_t vertex_total) {
    pc_textcursor c = piece->text;
    size_t vertex = piece->first_vertex;
    size_t face = piece->first_face;
    size_t triangle = piece->first_triangle;
    pc_polygon *polygon = faces->polygon + piece->first_polygon;
    for (;;) {
        pc_skip_spaces(&c);
        if (c.at == c.end) return;
        char word = keyword(&c);
        c.at++;
        if (word == 'v') {
            if (!read_vertex(piece, &c, vertex, mesh->position + 3 * vertex)) return;
            vertex++;
        } else if (word == 'f') {
            size_t count;
            if (!read_face(&count, faces->triangle + 3 * triangle, piece, &c, face, vertex, vertex_total))
                return;
            if (count > 1) *polygon++ = (pc_polygon){(pc_index)triangle, (pc_index)count + 2};
            triangle += count;
            face++;
        } else {
            pc_skip_line(&c);
        }
    }
}

/* ---- pieces ---- */

/* The first place from `at` on where a statement may begin. */
static const char *statement_start(const char *begin, const char *at, const char *end) {
    for (; at < end; at++) {
        if (!pc_is_newline(at[-1]) || pc_is_newline(*at)) continue;
        const char *p = at - 1;
        while (p > begin && pc_is_newline(*p))
            p--;
        if (*p != '\\') return at;
    }
    return end;
}

static pc_status make_pieces(obj_reader *r) {
    pc_status status = PC_OK;
    const char *begin = r->input->data;
    const char *end = begin + r->input->size;
    PC_TRY(pc_new(&r->piece, r->ctx, r->input->size / PIECE + 1));
    for (const char *at = begin; at < end; r->piece_count++) {
        const char *stop = end - at > PIECE ? statement_start(begin, at + PIECE, end) : end;
        r->piece[r->piece_count].text = (pc_textcursor){at, stop};
        at = stop;
    }
done:
    return status;
}

static void sum_pieces(obj_reader *r) {
    obj_piece *total = &r->total;
    for (size_t i = 0; i < r->piece_count; i++) {
        obj_piece *p = &r->piece[i];
        p->first_vertex = total->vertices;
        p->first_face = total->faces;
        p->first_triangle = total->triangles;
        p->first_polygon = total->polygons;
        total->vertices += p->vertices;
        total->faces += p->faces;
        total->triangles += p->triangles;
        total->polygons += p->polygons;
        total->short_faces += p->short_faces;
        total->normals |= p->normals;
        total->textures |= p->textures;
        total->others |= p->others;
    }
}

static pc_status first_error(obj_reader *r) {
    for (size_t i = 0; i < r->piece_count; i++) {
        r->total.colours |= r->piece[i].colours;
        const obj_error *error = &r->piece[i].error;
        if (!error->at) continue;
        size_t offset = (size_t)(error->at - r->input->data);
        pc_scan_word word = pc_scan_quote(error->at, r->input->data + r->input->size);
        return pc_scan_fail_line(r->ctx, r->input, offset, "%s %zu: '%s': %s", error->kind, error->element,
                                 word.text, error->what);
    }
    return PC_OK;
}

static void tell(pc_scan_info *info, const obj_piece *total) {
    info->vertex_count = total->vertices;
    info->face_count = total->faces;
    info->polygon_count = total->polygons;
    info->short_face_count = total->short_faces;
    if (total->normals) pc_scan_ignore(info, "normals");
    if (total->textures) pc_scan_ignore(info, "texture coordinates");
    if (total->colours) pc_scan_ignore(info, "colours");
    if (total->others) pc_scan_ignore(info, "other statements");
}

pc_status pc_obj_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input) {
    pc_status status = PC_OK;
    obj_reader r = {.mesh = mesh, .ctx = ctx, .input = input};
    *mesh = (pc_mesh){0};
    info->format = "OBJ";
    PC_TRY(make_pieces(&r));
#pragma omp parallel for schedule(static, 1)
    for (size_t i = 0; i < r.piece_count; i++)
        count_piece(&r.piece[i]);
    sum_pieces(&r);
    PC_TRY(pc_check_interrupt(ctx));
    PC_TRY(pc_scan_make_vertices(mesh, ctx, input, r.total.vertices));
    PC_TRY(pc_facelist_reserve(&r.faces, ctx, r.total.triangles));
    PC_TRY(pc_facelist_reserve_polygons(&r.faces, ctx, r.total.polygons));
#pragma omp parallel for schedule(static, 1)
    for (size_t i = 0; i < r.piece_count; i++)
        read_piece(&r.piece[i], mesh, &r.faces, r.total.vertices);
    PC_TRY(first_error(&r));
    r.faces.count = r.total.triangles;
    r.faces.polygon_count = r.total.polygons;
    tell(info, &r.total);
    mesh->face_count = (pc_index)r.faces.count;
    PC_TRY(pc_scan_check_counts(mesh, ctx, input, pc_scan_fail_line));
    PC_TRY(pc_facelist_finish(&r.faces, ctx, mesh));
done:
    pc_facelist_free(&r.faces, ctx);
    pc_free(ctx, r.piece);
    if (status != PC_OK) pc_mesh_free(mesh, ctx);
    return status;
}
