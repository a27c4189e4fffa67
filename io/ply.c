#include "ply.h"
#include "decimal.h"
#include "facelist.h"
#include "memory.h"
#include "ply_header.h"
#include "textcursor.h"
#include "triangulate.h"
#include <math.h>
#include <stdio.h>

typedef struct ply_reader {
    pc_mesh *mesh;
    pc_scan_info *info;
    pc_context *ctx;
    const pc_scan_input *input;
    const pc_ply_header *header;
    pc_textcursor text; /* the body, also where it is binary */
    const pc_ply_element *element;
    size_t record;
    size_t vertex_total; /* as the header says: faces may come first */
    pc_facelist faces;
    double *list; /* the list being read */
    size_t list_capacity;
    pc_index *corner; /* the same as corners */
} ply_reader;

/* What a property means to us. */
typedef enum role { ROLE_NONE, ROLE_X, ROLE_Y, ROLE_Z, ROLE_FACE, ROLE_STRIP } role;

static uint64_t load_bytes(const char *at, size_t size, bool big) {
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++)
        bits |= (uint64_t)(unsigned char)at[big ? size - 1 - i : i] << (8 * i);
    return bits;
}

static double as_float(uint64_t bits) {
    uint32_t word = (uint32_t)bits;
    float value;
    memcpy(&value, &word, sizeof value);
    return (double)value;
}

static double as_double(uint64_t bits) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline double load(const char *at, pc_ply_type type, bool big) {
    switch (type) {
    case PC_PLY_INT8:
        return (int8_t)*at;
    case PC_PLY_UINT8:
        return (uint8_t)*at;
    case PC_PLY_INT16:
        return (int16_t)load_bytes(at, 2, big);
    case PC_PLY_UINT16:
        return (uint16_t)load_bytes(at, 2, big);
    case PC_PLY_INT32:
        return (int32_t)load_bytes(at, 4, big);
    case PC_PLY_UINT32:
        return (uint32_t)load_bytes(at, 4, big);
    case PC_PLY_INT64:
        return (double)(int64_t)load_bytes(at, 8, big);
    case PC_PLY_UINT64:
        return (double)load_bytes(at, 8, big);
    case PC_PLY_FLOAT32:
        return as_float(load_bytes(at, 4, big));
    case PC_PLY_FLOAT64:
        return as_double(load_bytes(at, 8, big));
    case PC_PLY_TYPES:
        break;
    }
    return 0;
}

/* ---- messages ---- */

#define FAIL(r, at_, ...) fail_at((r), (at_), __VA_ARGS__)

__attribute__((format(printf, 3, 4))) static pc_status fail_at(const ply_reader *r, const char *at,
                                                               const char *format, ...) {
    char what[256];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    size_t offset = (size_t)(at - r->input->data);
    pc_scan_word name = pc_scan_quote(r->element->name.at, r->element->name.end);
    if (r->header->format == PC_PLY_ASCII)
        return pc_scan_fail_line(r->ctx, r->input, offset, "%s %zu: %s", name.text, r->record, what);
    return pc_scan_fail_byte(r->ctx, r->input, offset, "%s %zu: %s", name.text, r->record, what);
}

static pc_status fail_truncated(const ply_reader *r) {
    return FAIL(r, r->text.end,
                "the file ends here, before %zu records were read: it is truncated, get it anew",
                r->element->count);
}

/* ---- one value, list or record at a time: any format, any layout ---- */

static pc_status read_ascii(double *value, ply_reader *r) {
    pc_skip_spaces(&r->text);
    if (r->text.at == r->text.end) return fail_truncated(r);
    const char *word = r->text.at;
    pc_decimal_result result = pc_decimal_read(value, &r->text.at, r->text.end);
    if (result == PC_DECIMAL_NOT_FINITE) {
        r->text.at = pc_word_end(&r->text);
        *value = NAN;
        return PC_OK;
    }
    if (result == PC_DECIMAL_OK && pc_at_word_end(&r->text)) return PC_OK;
    r->text.at = word;
    if ((unsigned char)*word < ' ' || (unsigned char)*word > '~')
        return FAIL(r, word,
                    "binary bytes stand here, though the header says ascii: correct the format line");
    return FAIL(r, word, "'%s' is not a number", pc_scan_quote(word, r->text.end).text);
}

static pc_status read_value(double *value, ply_reader *r, pc_ply_type type) {
    if (r->header->format == PC_PLY_ASCII) return read_ascii(value, r);
    size_t size = pc_ply_type_size(type);
    if ((size_t)(r->text.end - r->text.at) < size) return fail_truncated(r);
    *value = load(r->text.at, type, r->header->format == PC_PLY_BIG);
    r->text.at += size;
    return PC_OK;
}

static pc_status list_room(ply_reader *r, size_t count) {
    pc_status status = PC_OK;
    if (count <= r->list_capacity) return PC_OK;
    size_t room = count + count / 2;
    PC_TRY(pc_resize(&r->list, r->ctx, room));
    PC_TRY(pc_resize(&r->corner, r->ctx, room));
    r->list_capacity = room;
done:
    return status;
}

static pc_status read_list(size_t *count, ply_reader *r, const pc_ply_property *property) {
    pc_status status = PC_OK;
    const char *start = r->text.at;
    double wanted = 0;
    PC_TRY(read_value(&wanted, r, property->count_type));
    bool ascii = r->header->format == PC_PLY_ASCII;
    size_t size = ascii ? 2 : pc_ply_type_size(property->type);
    size_t left = (size_t)(r->text.end - r->text.at) + ascii;
    if (!(wanted >= 0 && wanted == floor(wanted)))
        return FAIL(r, start, "a list of %g items makes no sense", wanted);
    size_t most = left / size;
    if (wanted > (double)most)
        return FAIL(
            r, start,
            "a list of %.0f items does not fit into the %zu bytes left: the file is damaged or truncated",
            wanted, left);
    *count = (size_t)wanted;
    PC_TRY(list_room(r, *count));
    for (size_t i = 0; i < *count; i++)
        PC_TRY(read_value(&r->list[i], r, property->type));
done:
    return status;
}

static pc_status check_corner(pc_index *corner, const ply_reader *r, const char *at, double value) {
    if (value >= 0 && value < (double)r->vertex_total && value == floor(value)) {
        *corner = (pc_index)value;
        return PC_OK;
    }
    return FAIL(r, at, "vertex index %.17g is not one of the %zu vertices", value, r->vertex_total);
}

static pc_status add_face(ply_reader *r, const char *at, size_t count) {
    pc_status status = PC_OK;
    for (size_t i = 0; i < count; i++)
        PC_TRY(check_corner(&r->corner[i], r, at, r->list[i]));
    r->info->face_count++;
    if (count < 3) {
        r->info->short_face_count++;
        return PC_OK;
    }
    if (count > PC_CUTTER_LIMIT)
        return FAIL(r, at, "%zu corners are more than %d: cut the face into smaller ones", count,
                    PC_CUTTER_LIMIT);
    r->info->polygon_count += count > 3;
    PC_TRY(pc_facelist_add(&r->faces, r->ctx, r->corner, count));
done:
    return status;
}

/* -1 begins a new strip; every second triangle of a strip runs the other way round. */
static pc_status add_strip(ply_reader *r, const char *at, size_t count) {
    pc_status status = PC_OK;
    size_t length = 0;
    for (size_t i = 0; i < count; i++) {
        if (r->list[i] == -1 || (r->list[i] == UINT32_MAX && r->vertex_total < UINT32_MAX)) {
            length = 0;
            continue;
        }
        PC_TRY(check_corner(&r->corner[i], r, at, r->list[i]));
        r->info->strip_count += length == 0;
        if (++length < 3) continue;
        bool odd = length % 2 == 0;
        const pc_index *c = r->corner + i - 2;
        if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
        const pc_index triangle[3] = {c[odd], c[!odd], c[2]};
        PC_TRY(pc_facelist_add(&r->faces, r->ctx, triangle, 3));
        r->info->face_count++;
    }
done:
    return status;
}

static pc_status take_coordinate(ply_reader *r, const char *at, int axis, double value) {
    if (!isfinite(value)) return FAIL(r, at, "%c is not a finite number: remove this vertex", "xyz"[axis]);
    r->mesh->position[3 * r->record + (size_t)axis] = value;
    return PC_OK;
}

static pc_status read_property(ply_reader *r, const pc_ply_property *property, role meaning) {
    pc_status status = PC_OK;
    if (r->header->format == PC_PLY_ASCII) pc_skip_spaces(&r->text);
    const char *at = r->text.at;
    if (property->is_list) {
        size_t count = 0;
        PC_TRY(read_list(&count, r, property));
        if (meaning == ROLE_FACE) PC_TRY(add_face(r, at, count));
        if (meaning == ROLE_STRIP) PC_TRY(add_strip(r, at, count));
    } else {
        double value;
        PC_TRY(read_value(&value, r, property->type));
        if (meaning != ROLE_NONE) PC_TRY(take_coordinate(r, at, (int)meaning - ROLE_X, value));
    }
done:
    return status;
}

static pc_status end_ascii_record(ply_reader *r) {
    pc_skip_blanks(&r->text);
    if (r->text.at == r->text.end || pc_is_newline(*r->text.at) || r->element->property_count == 0)
        return PC_OK;
    return FAIL(r, r->text.at,
                "'%s' follows: this line, or one before, has not as many values as the header says",
                pc_scan_quote(r->text.at, r->text.end).text);
}

static pc_status read_records(ply_reader *r, const role *roles) {
    pc_status status = PC_OK;
    const pc_ply_element *element = r->element;
    if (element->property_count == 0) return PC_OK;
    for (r->record = 0; r->record < element->count; r->record++) {
        if (r->record % 65536 == 0) PC_TRY(pc_check_interrupt(r->ctx));
        for (int i = 0; i < element->property_count; i++)
            PC_TRY(read_property(r, &r->header->property[element->first + i], roles[i]));
        if (r->header->format == PC_PLY_ASCII) PC_TRY(end_ascii_record(r));
    }
done:
    return status;
}

/* ---- many binary records of one size at a time; whatever is not as hoped is left to read_records ---- */

static size_t offset_of(const pc_ply_header *h, const pc_ply_element *element, int property) {
    size_t offset = 0;
    for (int i = element->first; i < property; i++)
        offset += pc_ply_type_size(h->property[i].type);
    return offset;
}

static bool vertices_at_once(ply_reader *r, const int *axis) {
    const pc_ply_header *h = r->header;
    const pc_ply_element *element = r->element;
    if (h->format == PC_PLY_ASCII || element->has_list) return false;
    size_t stride = element->least_bytes;
    if (element->count > (size_t)(r->text.end - r->text.at) / stride) return false;
    const char *body = r->text.at;
    double *position = r->mesh->position;
    bool big = h->format == PC_PLY_BIG;
    bool fine = true;
    pc_ply_type type[3];
    size_t offset[3];
    for (int k = 0; k < 3; k++) {
        type[k] = h->property[axis[k]].type;
        offset[k] = offset_of(h, element, axis[k]);
    }
#pragma omp parallel for schedule(static) reduction(&& : fine)
    for (size_t i = 0; i < element->count; i++)
        for (size_t k = 0; k < 3; k++) {
            double value = load(body + i * stride + offset[k], type[k], big);
            fine = fine && isfinite(value);
            position[3 * i + k] = value;
        }
    if (fine) r->text.at += element->count * stride;
    return fine;
}

static bool triangles_at_once(ply_reader *r, int list) {
    const pc_ply_header *h = r->header;
    const pc_ply_element *element = r->element;
    const pc_ply_property *property = &h->property[list];
    if (h->format == PC_PLY_ASCII) return false;
    for (int i = element->first; i < element->first + element->property_count; i++)
        if (i != list && h->property[i].is_list) return false;
    size_t item = pc_ply_type_size(property->type);
    size_t stride = element->least_bytes + 3 * item;
    if (element->count > (size_t)(r->text.end - r->text.at) / stride) return false;
    const char *body = r->text.at + offset_of(h, element, list);
    size_t behind = pc_ply_type_size(property->count_type);
    pc_index *triangle = r->faces.triangle + 3 * r->faces.count;
    double limit = (double)r->vertex_total;
    bool big = h->format == PC_PLY_BIG;
    bool fine = true;
#pragma omp parallel for schedule(static) reduction(&& : fine)
    for (size_t f = 0; f < element->count; f++) {
        const char *at = body + f * stride;
        if (load(at, property->count_type, big) != 3) {
            fine = false;
            continue;
        }
        for (size_t k = 0; k < 3; k++) {
            double value = load(at + behind + k * item, property->type, big);
            bool good = value >= 0 && value < limit;
            pc_index corner = good ? (pc_index)value : 0;
            fine = fine && good && corner == value;
            triangle[3 * f + k] = corner;
        }
    }
    if (!fine) return false;
    r->text.at += element->count * stride;
    r->faces.count += element->count;
    r->info->face_count += element->count;
    return true;
}

/* ---- elements ---- */

static pc_status read_vertices(ply_reader *r) {
    pc_status status = PC_OK;
    static const char *const names[3] = {"x", "y", "z"};
    role roles[PC_PLY_MAX_PROPERTIES] = {ROLE_NONE};
    int axis[3];
    if (r->mesh->position)
        return pc_scan_fail_line(r->ctx, r->input, r->header->body - 1,
                                 "two elements called vertex in the PLY header");
    for (int k = 0; k < 3; k++) {
        axis[k] = pc_ply_find(r->header, r->element, names[k]);
        if (axis[k] < 0 || r->header->property[axis[k]].is_list)
            return pc_scan_fail_line(r->ctx, r->input, r->header->body - 1,
                                     "element vertex has no number %s in the PLY header", names[k]);
        roles[axis[k] - r->element->first] = (role)(ROLE_X + k);
    }
    if (pc_ply_find(r->header, r->element, "nx") >= 0) pc_scan_ignore(r->info, "normals");
    if (pc_ply_find(r->header, r->element, "red") >= 0 ||
        pc_ply_find(r->header, r->element, "diffuse_red") >= 0)
        pc_scan_ignore(r->info, "colours");
    if (pc_ply_find(r->header, r->element, "s") >= 0 || pc_ply_find(r->header, r->element, "u") >= 0)
        pc_scan_ignore(r->info, "texture coordinates");
    PC_TRY(pc_scan_make_vertices(r->mesh, r->ctx, r->input, r->element->count));
    r->info->vertex_count = r->element->count;
    if (!vertices_at_once(r, axis)) PC_TRY(read_records(r, roles));
done:
    return status;
}

static int index_list(const ply_reader *r) {
    static const char *const names[] = {"vertex_indices", "vertex_index"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        int list = pc_ply_find(r->header, r->element, names[i]);
        if (list >= 0 && r->header->property[list].is_list) return list;
    }
    return -1;
}

static pc_status read_faces(ply_reader *r, role meaning) {
    pc_status status = PC_OK;
    role roles[PC_PLY_MAX_PROPERTIES] = {ROLE_NONE};
    int list = index_list(r);
    if (list < 0)
        return pc_scan_fail_line(r->ctx, r->input, r->header->body - 1,
                                 "element %s has no list vertex_indices in the PLY header",
                                 meaning == ROLE_FACE ? "face" : "tristrips");
    roles[list - r->element->first] = meaning;
    if (meaning == ROLE_FACE) {
        PC_TRY(pc_facelist_reserve(&r->faces, r->ctx, r->faces.count + r->element->count));
        if (triangles_at_once(r, list)) goto done;
    }
    PC_TRY(read_records(r, roles));
done:
    return status;
}

static pc_status skip_element(ply_reader *r) {
    const role roles[PC_PLY_MAX_PROPERTIES] = {ROLE_NONE};
    size_t bytes = r->element->count * r->element->least_bytes;
    if (r->element->count > 0 && r->element->property_count > 0) pc_scan_ignore(r->info, "other elements");
    if (r->header->format == PC_PLY_ASCII || r->element->has_list) return read_records(r, roles);
    if (bytes > (size_t)(r->text.end - r->text.at)) return fail_truncated(r);
    r->text.at += bytes;
    return PC_OK;
}

static pc_status read_elements(ply_reader *r) {
    pc_status status = PC_OK;
    const pc_ply_header *h = r->header;
    for (int e = 0; e < h->element_count; e++)
        if (pc_ply_name_is(h->element[e].name, "vertex")) r->vertex_total = h->element[e].count;
    for (int e = 0; e < h->element_count; e++) {
        r->element = &h->element[e];
        if (pc_ply_name_is(r->element->name, "vertex"))
            PC_TRY(read_vertices(r));
        else if (pc_ply_name_is(r->element->name, "face"))
            PC_TRY(read_faces(r, ROLE_FACE));
        else if (pc_ply_name_is(r->element->name, "tristrips"))
            PC_TRY(read_faces(r, ROLE_STRIP));
        else
            PC_TRY(skip_element(r));
    }
done:
    return status;
}

/* Text would pass for floats without any sense: nothing but the characters of numbers shows it. */
static pc_status check_binary(const ply_reader *r) {
    size_t size = (size_t)(r->text.end - r->text.at);
    if (r->header->format == PC_PLY_ASCII || size < 24) return PC_OK;
    if (size > 256) size = 256;
    for (size_t i = 0; i < size; i++)
        if (r->text.at[i] == '\0' || !strchr("0123456789+-.eE \t\r\n", r->text.at[i])) return PC_OK;
    return pc_scan_fail_byte(
        r->ctx, r->input, r->header->body,
        "numbers stand here as text, though the header says binary: correct the format line");
}

pc_status pc_ply_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input) {
    static const char *const names[] = {"PLY ascii", "PLY binary little-endian", "PLY binary big-endian"};
    pc_status status = PC_OK;
    pc_ply_header *header = NULL;
    ply_reader reader = {.mesh = mesh, .info = info, .ctx = ctx, .input = input};
    *mesh = (pc_mesh){0};
    PC_TRY(pc_new(&header, ctx, 1));
    PC_TRY(pc_ply_header_read(header, ctx, input));
    info->format = names[header->format];
    reader.header = header;
    reader.text = (pc_textcursor){input->data + header->body, input->data + input->size};
    PC_TRY(check_binary(&reader));
    PC_TRY(read_elements(&reader));
    mesh->face_count = (pc_index)reader.faces.count;
    PC_TRY(pc_scan_check_counts(mesh, ctx, input,
                                header->format == PC_PLY_ASCII ? pc_scan_fail_line : pc_scan_fail_byte));
    PC_TRY(pc_facelist_finish(&reader.faces, ctx, mesh));
done:
    pc_facelist_free(&reader.faces, ctx);
    pc_free(ctx, reader.list);
    pc_free(ctx, reader.corner);
    pc_free(ctx, header);
    if (status != PC_OK) pc_mesh_free(mesh, ctx);
    return status;
}
