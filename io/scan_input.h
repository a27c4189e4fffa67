/* What all scan readers share: the bytes, what was found in them, and messages that say where it went wrong.
 */
#ifndef PC_SCAN_INPUT_H
#define PC_SCAN_INPUT_H

#include "trimesh.h"

/* The whole file in memory, unpacked where it was packed. */
typedef struct pc_scan_input {
    const char *name; /* for messages */
    const char *data;
    size_t size;
    bool unpacked; /* offsets count in the unpacked bytes: messages say so */
} pc_scan_input;

/* What the file held, before any repair. */
typedef struct pc_scan_info {
    const char *format;      /* static text, such as "PLY binary little-endian" */
    bool gzip;               /* the file was packed */
    size_t file_bytes;       /* as on disk */
    size_t content_bytes;    /* after unpacking */
    size_t vertex_count;     /* as in the file; STL: three per face */
    size_t face_count;       /* as in the file, polygons counted once, triangles of strips one by one */
    size_t polygon_count;    /* faces with more than three corners, split into triangles */
    size_t strip_count;      /* triangle strips */
    size_t short_face_count; /* faces with fewer than three corners, left out */
    size_t welded_count;     /* corners that took the index of an equal position (STL only) */
    char ignored[128];       /* what else the file holds, such as "colours, normals"; "" where nothing */
} pc_scan_info;

/* Notes `what` once in info->ignored. */
void pc_scan_ignore(pc_scan_info *info, const char *what);

/* Fails with PC_E_FORMAT and "NAME:LINE: ..." (text) or "NAME: byte N: ..." (binary) for the place `offset`.
 */
pc_status pc_scan_fail_line(pc_context *ctx, const pc_scan_input *input, size_t offset, const char *format,
                            ...) __attribute__((format(printf, 4, 5)));
pc_status pc_scan_fail_byte(pc_context *ctx, const pc_scan_input *input, size_t offset, const char *format,
                            ...) __attribute__((format(printf, 4, 5)));

/* Zeroed positions for so many vertices. PC_E_FORMAT where an index could not count them. */
pc_status pc_scan_make_vertices(pc_mesh *mesh, pc_context *ctx, const pc_scan_input *input, size_t count);
/* PC_E_FORMAT where there is nothing to convert: no vertices, or no faces. `fail` says where the end is: by
 * line or byte. */
typedef pc_status pc_scan_fail(pc_context *ctx, const pc_scan_input *input, size_t offset, const char *format,
                               ...);
pc_status pc_scan_check_counts(const pc_mesh *mesh, pc_context *ctx, const pc_scan_input *input,
                               pc_scan_fail *fail);

/* A word of the file for a message: printable, at most 24 characters. */
typedef struct pc_scan_word {
    char text[28];
} pc_scan_word;
pc_scan_word pc_scan_quote(const char *at, const char *end);

#endif
