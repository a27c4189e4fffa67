/* Writes JSON text: members in the order of the calls, the same bytes for the same values. */
#ifndef PC_JSON_H
#define PC_JSON_H

#include "context.h"

enum { PC_JSON_DEPTH = 16 };

/* A text being built. Errors are kept and told by pc_json_end, so that the calls between need no checks. */
typedef struct pc_json {
    pc_context *ctx;
    char *text; /* NUL-terminated once anything was written */
    size_t length;
    size_t capacity;
    unsigned depth;
    char closer[PC_JSON_DEPTH];
    bool empty[PC_JSON_DEPTH];
    bool spread[PC_JSON_DEPTH]; /* one member per line */
    bool compact;
    pc_status status;
} pc_json;

/* `compact` writes no space at all: the form that is hashed. */
void pc_json_start(pc_json *json, pc_context *ctx, bool compact);
void pc_json_free(pc_json *json);

/* `key` is NULL for the root and for elements of arrays. */
void pc_json_object(pc_json *json, const char *key);
void pc_json_array(pc_json *json, const char *key);
/* An object or array whose members stay on one line. */
void pc_json_flat_object(pc_json *json, const char *key);
void pc_json_flat_array(pc_json *json, const char *key);
void pc_json_close(pc_json *json);

/* Bytes that are not UTF-8 become U+FFFD; NULL becomes null. */
void pc_json_string(pc_json *json, const char *key, const char *value);
void pc_json_integer(pc_json *json, const char *key, int64_t value);
/* Nine significant digits; null where not finite. */
void pc_json_number(pc_json *json, const char *key, double value);
/* All seventeen digits, for options that are hashed. */
void pc_json_exact(pc_json *json, const char *key, double value);
void pc_json_boolean(pc_json *json, const char *key, bool value);
/* JSON text made elsewhere. */
void pc_json_raw(pc_json *json, const char *key, const char *value);

/* Ends the text with a line feed (none where compact). PC_E_NOMEM, or PC_E_BUG where brackets are left open.
 */
pc_status pc_json_end(pc_json *json);

#endif
