#include "scan_input.h"
#include "memory.h"
#include <stdio.h>
#include <string.h>

void pc_scan_ignore(pc_scan_info *info, const char *what) {
    size_t used = strlen(info->ignored);
    if (strstr(info->ignored, what)) return;
    (void)snprintf(info->ignored + used, sizeof info->ignored - used, "%s%s", used ? ", " : "", what);
}

static size_t line_of(const pc_scan_input *input, size_t offset) {
    size_t line = 1;
    size_t stop = offset < input->size ? offset : input->size;
    char newline = memchr(input->data, '\n', input->size) ? '\n' : '\r';
    for (size_t i = 0; i < stop; i++)
        line += input->data[i] == newline;
    return line;
}

pc_status pc_scan_fail_line(pc_context *ctx, const pc_scan_input *input, size_t offset, const char *format,
                            ...) {
    char what[512];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    size_t line = input->data ? line_of(input, offset) : 1;
    return pc_fail(ctx, PC_E_FORMAT, "%s:%zu: %s", input->name, line, what);
}

pc_status pc_scan_fail_byte(pc_context *ctx, const pc_scan_input *input, size_t offset, const char *format,
                            ...) {
    char what[512];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return pc_fail(ctx, PC_E_FORMAT, "%s: byte %zu%s: %s", input->name, offset,
                   input->unpacked ? " (unpacked)" : "", what);
}

pc_status pc_scan_make_vertices(pc_mesh *mesh, pc_context *ctx, const pc_scan_input *input, size_t count) {
    if (count >= PC_NONE - 1)
        return pc_fail(ctx, PC_E_FORMAT, "%s: %zu vertices exceed the 32-bit indices of this version",
                       input->name, count);
    mesh->vertex_count = (pc_index)count;
    return pc_new(&mesh->position, ctx, 3 * count);
}

pc_status pc_scan_check_counts(const pc_mesh *mesh, pc_context *ctx, const pc_scan_input *input,
                               pc_scan_fail *fail) {
    if (mesh->vertex_count == 0)
        return fail(ctx, input, input->size, "end of file without a single vertex: nothing to convert");
    if (mesh->face_count == 0)
        return fail(ctx, input, input->size,
                    "end of file after %u vertices without a face: a point cloud must be meshed first",
                    mesh->vertex_count);
    return PC_OK;
}

pc_scan_word pc_scan_quote(const char *at, const char *end) {
    pc_scan_word word = {{0}};
    size_t n = 0;
    while (at < end && n < 24 && *at != ' ' && *at != '\t' && *at != '\r' && *at != '\n') {
        word.text[n++] = *at > ' ' && *at <= '~' ? *at : '?';
        at++;
    }
    if (n == 24) memcpy(word.text + n, "...", 4);
    return word;
}
