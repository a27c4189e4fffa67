#include "textout.h"
#include <stdio.h>

pc_status pc_textout_open(pc_textout *out, pc_context *ctx, const char *path, bool force) {
    out->status = pc_writer_open(&out->writer, ctx, path, force);
    return out->status;
}

void pc_textout_put(pc_textout *out, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (out->status == PC_OK) out->status = pc_writer_put(&out->writer, text, (size_t)length);
}

void pc_textout_reals(pc_textout *out, const double *x, size_t count) {
    char text[PC_DECIMAL_SPACE + 1];
    for (size_t i = 0; i < count; i++) {
        size_t length = 0;
        if (i) text[length++] = ' ';
        if (x[i] == 0)
            text[length++] = '0';
        else
            length += pc_decimal_write(text + length, x[i]);
        if (out->status == PC_OK) out->status = pc_writer_put(&out->writer, text, length);
    }
}

pc_status pc_textout_close(pc_textout *out, pc_status status) {
    if (status == PC_OK) status = out->status;
    if (status == PC_OK) status = pc_writer_commit(&out->writer);
    if (status != PC_OK) pc_writer_abandon(&out->writer);
    return status;
}
