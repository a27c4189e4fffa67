/* HTML as text that grows, also well-formed as XML. */
#ifndef PC_HTML_TEXT_H
#define PC_HTML_TEXT_H

#include "context.h"

/* Errors are kept and told by pc_html_end, so that the calls between need no checks. */
typedef struct pc_html {
    pc_context *ctx;
    char *text; /* NUL-terminated once anything was written */
    size_t length, room;
    pc_status status;
} pc_html;

void pc_html_start(pc_html *html, pc_context *ctx);
void pc_html_free(pc_html *html);
pc_status pc_html_end(const pc_html *html);

/* Markup as it stands. */
void pc_html_put(pc_html *html, const char *markup);
/* Markup with the places of `format` filled in, up to 500 bytes; not for text from outside. */
void pc_html_print(pc_html *html, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Text from anywhere: markup in it loses its meaning, what is no UTF-8 becomes U+FFFD. NULL is nothing. */
void pc_html_escape(pc_html *html, const char *text);
/* Bytes as base64. */
void pc_html_base64(pc_html *html, const uint8_t *data, size_t size);

/* "12,345" */
void pc_html_count(pc_html *html, double value);
/* Three digits that mean something, without an exponent from 1e-5 to 1e6; a dash where not finite. */
void pc_html_number(pc_html *html, double value);
/* "1.2 GB" */
void pc_html_bytes(pc_html *html, double bytes);

#endif
