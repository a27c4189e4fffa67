#include "scan.h"
#include "file.h"
#include "gunzip.h"
#include "memory.h"
#include "obj.h"
#include "off.h"
#include "ply.h"
#include "stl.h"
#include "textcursor.h"

typedef pc_status read_scan(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const pc_scan_input *input);

typedef enum kind { KIND_PLY, KIND_OBJ, KIND_STL, KIND_OFF, KINDS, KIND_UNKNOWN = KINDS } kind;

static const struct {
    const char *name;
    const char *extension;
    read_scan *read;
} kinds[KINDS] = {{"PLY", "ply", pc_ply_read},
                  {"OBJ", "obj", pc_obj_read},
                  {"STL", "stl", pc_stl_read},
                  {"OFF", "off", pc_off_read}};

/* ---- by name ---- */

static bool ends_with(const char *name, size_t length, const char *extension) {
    size_t n = strlen(extension);
    if (length < n + 1 || name[length - n - 1] != '.') return false;
    for (size_t i = 0; i < n; i++)
        if ((name[length - n + i] | 0x20) != extension[i]) return false;
    return true;
}

static kind kind_by_name(const char *name) {
    size_t length = strlen(name);
    if (ends_with(name, length, "gz")) length -= 3;
    for (int k = 0; k < KINDS; k++)
        if (ends_with(name, length, kinds[k].extension)) return (kind)k;
    /* coff, noff, stoff, ... are names of the same format */
    if (ends_with(name, length, "coff") || ends_with(name, length, "noff")) return KIND_OFF;
    return KIND_UNKNOWN;
}

/* ---- by content ---- */

static bool looks_like_off(pc_textcursor c) {
    if (!pc_skip_comments(&c)) return false;
    const char *end = pc_word_end(&c);
    return end - c.at >= 3 && end - c.at <= 9 && memcmp(end - 3, "OFF", 3) == 0;
}

static bool looks_like_stl(const pc_scan_input *input) {
    pc_textcursor c = {input->data, input->data + input->size};
    pc_skip_spaces(&c);
    bool solid = c.end - c.at > 5 && pc_word_is(c.at, c.at + 5, "solid");
    if (!pc_stl_is_binary(input->data, input->size)) return true;
    if (input->size < 84) return false;
    /* binary without the word: only the exact size tells */
    const unsigned char *p = (const unsigned char *)input->data + 80;
    size_t count = (size_t)p[0] | (size_t)p[1] << 8 | (size_t)p[2] << 16 | (size_t)p[3] << 24;
    return input->size == 84 + 50 * count || (solid && memchr(c.at, 0, 84) != NULL);
}

/* The first statement that is not a comment is one of OBJ's. */
static bool looks_like_obj(pc_textcursor c) {
    static const char *const statements[] = {"v", "vn", "vt",     "vp",     "f", "o",
                                             "g", "s",  "mtllib", "usemtl", "l", "p"};
    if (!pc_skip_comments(&c)) return false;
    const char *end = pc_word_end(&c);
    for (size_t i = 0; i < sizeof statements / sizeof *statements; i++)
        if (pc_word_is(c.at, end, statements[i])) return true;
    return false;
}

static kind kind_by_content(const pc_scan_input *input) {
    pc_textcursor c = {input->data, input->data + input->size};
    if (input->size > 3 && memcmp(c.at, "ply", 3) == 0 && pc_is_space(c.at[3])) return KIND_PLY;
    if (looks_like_off(c)) return KIND_OFF;
    if (looks_like_stl(input)) return KIND_STL;
    return looks_like_obj(c) ? KIND_OBJ : KIND_UNKNOWN;
}

/* ---- what people also have ---- */

static const char *known_other(const pc_scan_input *input) {
    static const struct {
        const char *magic;
        size_t size;
        const char *what;
    } others[] = {{"PK\3\4", 4, "a zip archive (or 3MF): unpack it or export PLY"},
                  {"\xfd"
                   "7zXZ",
                   5, "packed by xz: unpack it first"},
                  {"BZh", 3, "packed by bzip2: unpack it first"},
                  {"\x28\xb5\x2f\xfd", 4, "packed by zstd: unpack it first"},
                  {"glTF", 4, "a glTF scene: export PLY from it"},
                  {"\x89HDF", 4, "an HDF5 file, not a scan"},
                  {"# vtk", 5, "a VTK file: export PLY from it"},
                  {"\xff\xfe", 2, "UTF-16 text: save it as UTF-8"},
                  {"\xfe\xff", 2, "UTF-16 text: save it as UTF-8"}};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (input->size >= others[i].size && memcmp(input->data, others[i].magic, others[i].size) == 0)
            return others[i].what;
    return NULL;
}

static void skip_byte_order_mark(pc_scan_input *input) {
    if (input->size >= 3 && memcmp(input->data, "\xef\xbb\xbf", 3) == 0) {
        input->data += 3;
        input->size -= 3;
    }
}

static pc_status read_content(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, pc_scan_input input) {
    kind named = kind_by_name(input.name);
    if (input.size == 0) return pc_fail(ctx, PC_E_FORMAT, "%s: byte 0: the file is empty", input.name);
    skip_byte_order_mark(&input);
    kind found = kind_by_content(&input);
    if (found == KIND_UNKNOWN) {
        const char *known = known_other(&input);
        if (known) return pc_scan_fail_byte(ctx, &input, 0, "this is %s", known);
        if (named == KIND_UNKNOWN)
            return pc_scan_fail_byte(ctx, &input, 0, "the content is none of PLY, OBJ, STL, OFF: export PLY");
        found = named;
    }
    if (named != KIND_UNKNOWN && named != found)
        return pc_scan_fail_byte(ctx, &input, 0,
                                 "the content is %s but the name says %s: rename the file to .%s",
                                 kinds[found].name, kinds[named].name, kinds[found].extension);
    pc_status status = kinds[found].read(mesh, info, ctx, &input);
    if (status == PC_OK && info->short_face_count > 0)
        pc_log(ctx, PC_LOG_WARNING, "%s: %zu faces with fewer than three corners are left out", input.name,
               info->short_face_count);
    return status;
}

pc_status pc_scan_read_bytes(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const char *name,
                             const char *data, size_t size) {
    pc_status status = PC_OK;
    char *unpacked = NULL;
    pc_scan_input input = {.name = name, .data = data, .size = size};
    *mesh = (pc_mesh){0};
    *info = (pc_scan_info){.file_bytes = size, .gzip = pc_gunzip_is(data, size)};
    if (info->gzip) {
        PC_TRY(pc_gunzip(&unpacked, &input.size, ctx, name, data, size));
        input.data = unpacked;
        input.unpacked = true;
    }
    info->content_bytes = input.size;
    PC_TRY(read_content(mesh, info, ctx, input));
done:
    pc_free(ctx, unpacked);
    return status;
}

pc_status pc_scan_read(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const char *path) {
    pc_status status = PC_OK;
    pc_file file = {0};
    *mesh = (pc_mesh){0};
    *info = (pc_scan_info){0};
    PC_TRY(pc_file_open(&file, ctx, path));
    PC_TRY(pc_scan_read_bytes(mesh, info, ctx, path, file.data, file.size));
done:
    pc_file_close(&file, ctx);
    return status;
}
