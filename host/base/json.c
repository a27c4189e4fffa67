#include "json.h"
#include "memory.h"
#include "utf8.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void pc_json_start(pc_json *json, pc_context *ctx, bool compact) {
    *json = (pc_json){.ctx = ctx, .compact = compact, .empty = {true}};
}

void pc_json_free(pc_json *json) {
    if (!json || !json->ctx) return;
    pc_free(json->ctx, json->text);
    *json = (pc_json){0};
}

static void append(pc_json *json, const char *bytes, size_t count) {
    if (json->status != PC_OK) return;
    if (json->length + count + 1 > json->capacity) {
        size_t capacity = 2 * (json->length + count) + 256;
        json->status = pc_resize(&json->text, json->ctx, capacity);
        if (json->status != PC_OK) return;
        json->capacity = capacity;
    }
    memcpy(json->text + json->length, bytes, count);
    json->length += count;
    json->text[json->length] = '\0';
}

static void append_text(pc_json *json, const char *text) {
    append(json, text, strlen(text));
}

static void new_line(pc_json *json) {
    if (json->compact) return;
    append_text(json, "\n");
    for (unsigned i = 0; i < json->depth; i++)
        append_text(json, "  ");
}

static void append_quoted(pc_json *json, const char *value) {
    append_text(json, "\"");
    for (const unsigned char *s = (const unsigned char *)value; *s;) {
        size_t n = pc_utf8_length(s);
        char escape[8];
        if (n == 0) {
            append_text(json, "\xef\xbf\xbd");
            n = 1;
        } else if (*s == '"' || *s == '\\') {
            append(json, "\\", 1);
            append(json, (const char *)s, 1);
        } else if (*s < 0x20) {
            (void)snprintf(escape, sizeof escape, "\\u%04x", *s);
            append_text(json, escape);
        } else {
            append(json, (const char *)s, n);
        }
        s += n;
    }
    append_text(json, "\"");
}

static void lead(pc_json *json, const char *key) {
    bool spread = json->depth > 0 && json->spread[json->depth];
    if (!json->empty[json->depth]) append_text(json, spread || json->compact ? "," : ", ");
    if (spread) new_line(json);
    json->empty[json->depth] = false;
    if (!key) return;
    append_quoted(json, key);
    append_text(json, json->compact ? ":" : ": ");
}

static void open_bracket(pc_json *json, const char *key, const char *bracket, bool spread) {
    lead(json, key);
    append_text(json, bracket);
    if (json->depth + 1 == PC_JSON_DEPTH) {
        if (json->status == PC_OK) json->status = pc_fail(json->ctx, PC_E_BUG, "JSON nests too deep");
        return;
    }
    json->depth++;
    json->closer[json->depth] = bracket[0] == '{' ? '}' : ']';
    json->empty[json->depth] = true;
    json->spread[json->depth] = spread && !json->compact;
}

void pc_json_object(pc_json *json, const char *key) {
    open_bracket(json, key, "{", true);
}

void pc_json_array(pc_json *json, const char *key) {
    open_bracket(json, key, "[", true);
}

void pc_json_flat_object(pc_json *json, const char *key) {
    open_bracket(json, key, "{", false);
}

void pc_json_flat_array(pc_json *json, const char *key) {
    open_bracket(json, key, "[", false);
}

void pc_json_close(pc_json *json) {
    if (json->depth == 0) {
        if (json->status == PC_OK)
            json->status = pc_fail(json->ctx, PC_E_BUG, "JSON closes what is not open");
        return;
    }
    unsigned depth = json->depth--;
    if (json->spread[depth] && !json->empty[depth]) new_line(json);
    append(json, &json->closer[depth], 1);
}

void pc_json_string(pc_json *json, const char *key, const char *value) {
    lead(json, key);
    if (value)
        append_quoted(json, value);
    else
        append_text(json, "null");
}

void pc_json_integer(pc_json *json, const char *key, int64_t value) {
    char text[32];
    (void)snprintf(text, sizeof text, "%" PRId64, value);
    pc_json_raw(json, key, text);
}

static void put_number(pc_json *json, const char *key, double value, int digits) {
    char text[64];
    (void)snprintf(text, sizeof text, "%.*g", digits, value);
    pc_json_raw(json, key, isfinite(value) ? text : "null");
}

void pc_json_number(pc_json *json, const char *key, double value) {
    put_number(json, key, value, 9);
}

void pc_json_exact(pc_json *json, const char *key, double value) {
    put_number(json, key, value, 17);
}

void pc_json_boolean(pc_json *json, const char *key, bool value) {
    pc_json_raw(json, key, value ? "true" : "false");
}

void pc_json_raw(pc_json *json, const char *key, const char *value) {
    lead(json, key);
    append_text(json, value);
}

pc_status pc_json_end(pc_json *json) {
    if (json->status == PC_OK && json->depth != 0)
        json->status = pc_fail(json->ctx, PC_E_BUG, "JSON has open brackets");
    if (!json->compact) append_text(json, "\n");
    return json->status;
}
