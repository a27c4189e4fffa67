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
    pc_textout_text(out, text, (size_t)length);
}

void pc_textout_text(pc_textout *out, const char *text, size_t length) {
    if (out->status == PC_OK) out->status = pc_writer_put(&out->writer, text, length);
}

void pc_textout_integer(pc_textout *out, uint64_t value) {
    char text[20];
    size_t at = sizeof text;
    do {
        text[--at] = (char)('0' + value % 10);
        value /= 10;
    } while (value > 0);
    pc_textout_text(out, text + at, sizeof text - at);
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
        pc_textout_text(out, text, length);
    }
}

pc_status pc_textout_close(pc_textout *out, pc_status status) {
    if (status == PC_OK) status = out->status;
    if (status == PC_OK) status = pc_writer_commit(&out->writer);
    if (status != PC_OK) pc_writer_abandon(&out->writer);
    return status;
}
