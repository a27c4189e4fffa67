#include "html_text.h"
#include "memory.h"
#include "utf8.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void pc_html_start(pc_html *html, pc_context *ctx) {
    *html = (pc_html){.ctx = ctx};
}

void pc_html_free(pc_html *html) {
    if (html->ctx) pc_free(html->ctx, html->text);
    *html = (pc_html){0};
}

pc_status pc_html_end(const pc_html *html) {
    return html->status;
}

/* Room for `count` more bytes and a NUL; false where there is none. */
static bool make_room(pc_html *html, size_t count) {
    if (html->status != PC_OK) return false;
    if (html->length + count + 1 <= html->room) return true;
    size_t room = 2 * html->length + count + 4096;
    html->status = pc_resize(&html->text, html->ctx, room);
    if (html->status == PC_OK) html->room = room;
    return html->status == PC_OK;
}

static void append(pc_html *html, const char *bytes, size_t count) {
    if (!make_room(html, count)) return;
    memcpy(html->text + html->length, bytes, count);
    html->length += count;
    html->text[html->length] = '\0';
}

void pc_html_put(pc_html *html, const char *markup) {
    append(html, markup, strlen(markup));
}

void pc_html_print(pc_html *html, const char *format, ...) {
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    pc_html_put(html, line);
}

void pc_html_escape(pc_html *html, const char *text) {
    for (const unsigned char *s = (const unsigned char *)(text ? text : ""); *s;) {
        size_t n = pc_utf8_length(s);
        /* XML has neither most control characters nor the two last places of the first plane. */
        bool outside = n == 0 || (*s < 0x20 && *s != '\t' && *s != '\n') || *s == 0x7f ||
                       (n == 3 && s[0] == 0xef && s[1] == 0xbf && s[2] >= 0xbe);
        const char *named = *s == '&'    ? "&amp;"
                            : *s == '<'  ? "&lt;"
                            : *s == '>'  ? "&gt;"
                            : *s == '"'  ? "&quot;"
                            : *s == '\'' ? "&#39;"
                                         : NULL;
        if (outside)
            pc_html_put(html, "\xef\xbf\xbd");
        else if (named)
            pc_html_put(html, named);
        else
            append(html, (const char *)s, n);
        s += n ? n : 1;
    }
}

void pc_html_base64(pc_html *html, const uint8_t *data, size_t size) {
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (!make_room(html, (size + 2) / 3 * 4)) return;
    char *out = html->text + html->length;
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t three = (uint32_t)data[i] << 16 | (left > 1 ? (uint32_t)data[i + 1] << 8 : 0) |
                         (left > 2 ? data[i + 2] : 0);
        *out++ = digit[three >> 18];
        *out++ = digit[three >> 12 & 63];
        *out++ = (char)(left > 1 ? digit[three >> 6 & 63] : '=');
        *out++ = (char)(left > 2 ? digit[three & 63] : '=');
    }
    *out = '\0';
    html->length = (size_t)(out - html->text);
}

void pc_html_count(pc_html *html, double value) {
    char digits[32], grouped[48];
    size_t out = 0;
    (void)snprintf(digits, sizeof digits, "%.0f", fabs(value) < 1e15 ? value : 0);
    size_t length = strlen(digits), sign = digits[0] == '-';
    for (size_t i = 0; i < length; i++) {
        if (i > sign && (length - i) % 3 == 0) grouped[out++] = ',';
        grouped[out++] = digits[i];
    }
    grouped[out] = '\0';
    pc_html_put(html, grouped);
}

void pc_html_number(pc_html *html, double value) {
    double size = fabs(value);
    if (!isfinite(value))
        pc_html_put(html, "&#8211;");
    else if (size >= 1e5 && size < 1e6)
        pc_html_count(html, value);
    else if (size >= 1e-5 && size < 1e-4)
        pc_html_print(html, "%.7f", value);
    else
        pc_html_print(html, size >= 1e3 && size < 1e5 ? "%.0f" : "%.3g", value);
}

void pc_html_bytes(pc_html *html, double bytes) {
    if (bytes >= 1e9)
        pc_html_print(html, "%.2f GB", 1e-9 * bytes);
    else if (bytes >= 1e6)
        pc_html_print(html, "%.0f MB", 1e-6 * bytes);
    else
        pc_html_print(html, "%.1f kB", 1e-3 * bytes);
}
