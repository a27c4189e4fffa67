#include "ply_header.h"
#include "decimal.h"
#include "textcursor.h"

static const struct {
    const char *name;
    const char *other_name;
    size_t size;
} types[PC_PLY_TYPES] = {{"char", "int8", 1},     {"uchar", "uint8", 1},  {"short", "int16", 2},
                         {"ushort", "uint16", 2}, {"int", "int32", 4},    {"uint", "uint32", 4},
                         {"long", "int64", 8},    {"ulong", "uint64", 8}, {"float", "float32", 4},
                         {"double", "float64", 8}};

/* The header as lines of words; `end` is where the current line ends. */
typedef struct header_reader {
    pc_ply_header *header;
    pc_context *ctx;
    const pc_scan_input *input;
    pc_textcursor line;
    const char *next;
    const char *end;
} header_reader;

size_t pc_ply_type_size(pc_ply_type type) {
    return types[type].size;
}

bool pc_ply_name_is(pc_ply_name name, const char *word) {
    return pc_word_is(name.at, name.end, word);
}

int pc_ply_find(const pc_ply_header *header, const pc_ply_element *element, const char *name) {
    for (int i = element->first; i < element->first + element->property_count; i++)
        if (pc_ply_name_is(header->property[i].name, name)) return i;
    return -1;
}

#define FAIL(r, ...)                                                                                         \
    pc_scan_fail_line((r)->ctx, (r)->input, (size_t)((r)->line.at - (r)->input->data), __VA_ARGS__)

/* A line ends with "\n", "\r\n" or "\r"; after the latter two the body may begin with any byte, so that only
 * the first line tells which it is. */
static bool next_line(header_reader *r, bool lone_cr) {
    const char *p = r->next;
    if (p == r->end) return false;
    r->line.at = p;
    while (p < r->end && !pc_is_newline(*p))
        p++;
    r->line.end = p;
    if (p < r->end && *p == '\r' && !lone_cr && p + 1 < r->end && p[1] == '\n') p++;
    r->next = p < r->end ? p + 1 : p;
    return true;
}

static pc_ply_name next_word(header_reader *r) {
    pc_skip_blanks(&r->line);
    pc_ply_name word = {r->line.at, pc_word_end(&r->line)};
    r->line.at = word.end;
    return word;
}

static pc_status read_type(pc_ply_type *type, header_reader *r) {
    pc_ply_name word = next_word(r);
    for (int i = 0; i < PC_PLY_TYPES; i++)
        if (pc_ply_name_is(word, types[i].name) || pc_ply_name_is(word, types[i].other_name)) {
            *type = (pc_ply_type)i;
            return PC_OK;
        }
    return FAIL(r, "unknown type '%s' in the PLY header", pc_scan_quote(word.at, word.end).text);
}

static pc_status read_format(header_reader *r) {
    pc_ply_name word = next_word(r);
    if (pc_ply_name_is(word, "ascii"))
        r->header->format = PC_PLY_ASCII;
    else if (pc_ply_name_is(word, "binary_little_endian"))
        r->header->format = PC_PLY_LITTLE;
    else if (pc_ply_name_is(word, "binary_big_endian"))
        r->header->format = PC_PLY_BIG;
    else
        return FAIL(r, "unknown PLY format '%s'", pc_scan_quote(word.at, word.end).text);
    return PC_OK;
}

static pc_status read_element(header_reader *r) {
    pc_ply_header *h = r->header;
    int64_t count;
    if (h->element_count == PC_PLY_MAX_ELEMENTS)
        return FAIL(r, "more than %d elements in the PLY header", PC_PLY_MAX_ELEMENTS);
    pc_ply_element *element = &h->element[h->element_count++];
    *element = (pc_ply_element){.name = next_word(r), .first = h->property_count};
    pc_skip_blanks(&r->line);
    if (!pc_decimal_read_integer(&count, &r->line.at, r->line.end) || !pc_at_word_end(&r->line) || count < 0)
        return FAIL(r, "element %s has no sensible count in the PLY header",
                    pc_scan_quote(element->name.at, element->name.end).text);
    element->count = (size_t)count;
    return PC_OK;
}

static pc_status read_property(header_reader *r) {
    pc_status status = PC_OK;
    pc_ply_header *h = r->header;
    if (h->element_count == 0) return FAIL(r, "a property before the first element in the PLY header");
    if (h->property_count == PC_PLY_MAX_PROPERTIES)
        return FAIL(r, "more than %d properties in the PLY header", PC_PLY_MAX_PROPERTIES);
    pc_ply_element *element = &h->element[h->element_count - 1];
    pc_ply_property property = {0};
    pc_textcursor before = r->line;
    property.is_list = pc_ply_name_is(next_word(r), "list");
    if (property.is_list)
        PC_TRY(read_type(&property.count_type, r));
    else
        r->line = before;
    PC_TRY(read_type(&property.type, r));
    if (property.is_list && property.count_type >= PC_PLY_FLOAT32)
        return FAIL(r, "a list in the PLY header is counted by a %s", types[property.count_type].name);
    property.name = next_word(r);
    if (property.name.at == property.name.end) return FAIL(r, "a property without a name in the PLY header");
    h->property[h->property_count++] = property;
    element->property_count++;
    element->has_list |= property.is_list;
    element->least_bytes +=
        h->format == PC_PLY_ASCII ? 2 : types[property.is_list ? property.count_type : property.type].size;
done:
    return status;
}

/* The format line comes first, so that sizes are known when properties follow. */
static pc_status read_lines(header_reader *r) {
    pc_status status = PC_OK;
    bool has_format = false;
    bool lone_cr = false;
    for (int i = 0; next_line(r, lone_cr); i++) {
        if (i == 0) lone_cr = r->next[-1] == '\r';
        pc_ply_name word = next_word(r);
        if (i == 0 || word.at == word.end || pc_ply_name_is(word, "comment") ||
            pc_ply_name_is(word, "obj_info"))
            continue;
        if (pc_ply_name_is(word, "end_header") && has_format) {
            r->header->body = (size_t)(r->next - r->input->data);
            return PC_OK;
        }
        if (pc_ply_name_is(word, "format"))
            PC_TRY(read_format(r));
        else if (!has_format)
            return FAIL(r, "no format line at the start of the PLY header");
        else if (pc_ply_name_is(word, "element"))
            PC_TRY(read_element(r));
        else if (pc_ply_name_is(word, "property"))
            PC_TRY(read_property(r));
        else
            return FAIL(r, "'%s' is no statement of a PLY header", pc_scan_quote(word.at, word.end).text);
        has_format = true;
    }
    status = FAIL(r, "the PLY header has no end_header line: the file is truncated");
done:
    return status;
}

/* Before anything is allocated: do the counts fit into the bytes that are there? */
static pc_status check_counts(const pc_ply_header *h, pc_context *ctx, const pc_scan_input *input) {
    size_t left = input->size - h->body + (h->format == PC_PLY_ASCII);
    for (int e = 0; e < h->element_count; e++) {
        const pc_ply_element *element = &h->element[e];
        size_t least;
        if (!__builtin_mul_overflow(element->count, element->least_bytes, &least) && least <= left) {
            left -= least;
            continue;
        }
        return pc_scan_fail_byte(
            ctx, input, h->body,
            "the header promises %zu records of element %s, at least %zu bytes each, but only %zu "
            "bytes are left of the file: it is truncated or the count is wrong; get it anew",
            element->count, pc_scan_quote(element->name.at, element->name.end).text, element->least_bytes,
            left);
    }
    return PC_OK;
}

pc_status pc_ply_header_read(pc_ply_header *header, pc_context *ctx, const pc_scan_input *input) {
    pc_status status = PC_OK;
    header_reader reader = {.header = header, .ctx = ctx, .input = input, .next = input->data};
    reader.end = input->data + input->size;
    reader.line = (pc_textcursor){input->data, reader.end};
    header->element_count = header->property_count = 0;
    PC_TRY(read_lines(&reader));
    PC_TRY(check_counts(header, ctx, input));
done:
    return status;
}
