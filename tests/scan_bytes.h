/* Small scan files made in memory: for the readers' tests and as seeds of the fuzzers. */
#ifndef PC_SCAN_BYTES_H
#define PC_SCAN_BYTES_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct scan_bytes {
    char data[8192];
    size_t size;
} scan_bytes;

static inline void put_bytes(scan_bytes *b, const void *data, size_t size) {
    if (size > sizeof b->data - b->size) size = sizeof b->data - b->size;
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

__attribute__((format(printf, 2, 3))) static inline void put_text(scan_bytes *b, const char *format, ...) {
    char text[4096];
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    put_bytes(b, text, (size_t)n);
}

static inline void put_integer(scan_bytes *b, uint64_t bits, size_t size, bool big) {
    for (size_t i = 0; i < size; i++) {
        unsigned char byte = (unsigned char)(bits >> (8 * (big ? size - 1 - i : i)));
        put_bytes(b, &byte, 1);
    }
}

static inline void put_float(scan_bytes *b, float value, bool big) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_integer(b, bits, 4, big);
}

static inline void put_double(scan_bytes *b, double value, bool big) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_integer(b, bits, 8, big);
}

/* A tetrahedron, counter-clockwise from outside: what most of the files below hold. */
static const double tetra_position[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5}};
static const uint32_t tetra_face[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

static inline void make_ply_ascii(scan_bytes *b) {
    put_text(
        b,
        "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nelement face 4\nproperty list uchar int vertex_indices\n"
        "end_header\n");
    for (int i = 0; i < 4; i++)
        put_text(b, "%g %g %g 255\n", tetra_position[i][0], tetra_position[i][1], tetra_position[i][2]);
    for (int f = 0; f < 4; f++)
        put_text(b, "3 %u %u %u\n", tetra_face[f][0], tetra_face[f][1], tetra_face[f][2]);
}

/* Shuffled properties of all sizes, an extra element before and a list on the vertices where `lists`. */
static inline void make_ply_binary(scan_bytes *b, bool big, bool lists) {
    put_text(b, "ply\nformat binary_%s_endian 1.0\n", big ? "big" : "little");
    if (lists) put_text(b, "element camera 2\nproperty list ushort double view\nproperty int8 id\n");
    put_text(b, "element vertex 4\nproperty uint8 quality\nproperty double z\nproperty float32 x\nproperty "
                "short y\n");
    if (lists) put_text(b, "property list uchar float weights\n");
    put_text(
        b,
        "element face 4\nproperty float area\nproperty list uint ushort vertex_index\nproperty char flags\n"
        "end_header\n");
    for (int i = 0; lists && i < 2; i++) {
        put_integer(b, (uint64_t)i + 1, 2, big);
        for (int k = 0; k <= i; k++)
            put_double(b, 0.5, big);
        put_integer(b, 7, 1, big);
    }
    for (int i = 0; i < 4; i++) {
        put_integer(b, 200, 1, big);
        put_double(b, tetra_position[i][2], big);
        put_float(b, (float)tetra_position[i][0], big);
        put_integer(b, (uint64_t)tetra_position[i][1], 2, big);
        if (lists) {
            put_integer(b, (uint64_t)i, 1, big);
            for (int k = 0; k < i; k++)
                put_float(b, 0.25F, big);
        }
    }
    for (int f = 0; f < 4; f++) {
        put_float(b, 0.5F, big);
        put_integer(b, 3, 4, big);
        for (int k = 0; k < 3; k++)
            put_integer(b, tetra_face[f][k], 2, big);
        put_integer(b, 1, 1, big);
    }
}

/* Two strips: 0 1 2 3, then -1, then 2 1 0. */
static inline void make_ply_strips(scan_bytes *b, bool big) {
    static const int strip[8] = {0, 1, 2, 3, -1, 2, 1, 0};
    put_text(
        b,
        "ply\r\nformat binary_%s_endian 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\n"
        "property float z\r\nelement tristrips 1\r\nproperty list int int vertex_indices\r\nend_header\r\n",
        big ? "big" : "little");
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            put_float(b, (float)tetra_position[i][k], big);
    put_integer(b, 8, 4, big);
    for (int i = 0; i < 8; i++)
        put_integer(b, (uint64_t)(int64_t)strip[i], 4, big);
}

static inline void make_obj(scan_bytes *b) {
    put_text(
        b, "# a comment \\\nmtllib some.mtl\r\no thing\n\nv 0 0 0 1 0 0\nv 1 0 0 \\\n 1 0 0\nv 0 1 0 # here\n"
           "  v\t0  0\t1.5\r\nvn 0 0 1\nvt 0 0\ng one\nusemtl red\ns off\nf 1/1/1 3/1/1 2/1/1\nf -4//1 "
           "\\\r\n -3//1 "
           "-1//1\nf 2/1 3/1 4/1\nf 3 1 4");
}

/* A square pyramid with an L-shaped lid: polygons of 3, 4 and 6 sides. */
static inline void make_obj_polygons(scan_bytes *b) {
    put_text(
        b,
        "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\nv 0 0 1\nv 2 0 1\nf 1 7 8 2\n"
        "f 1 6 7\n");
}

static inline void make_off(scan_bytes *b) {
    put_text(b, "# first\nCOFF\n# counts\n4 4 6 # edges too\n");
    for (int i = 0; i < 4; i++)
        put_text(b, "%g %g %g 255 0 0 255\n\n", tetra_position[i][0], tetra_position[i][1],
                 tetra_position[i][2]);
    for (int f = 0; f < 4; f++)
        put_text(b, "3 %u %u %u 255 0 0 # red\r\n", tetra_face[f][0], tetra_face[f][1], tetra_face[f][2]);
}

static inline void make_stl_ascii(scan_bytes *b) {
    put_text(b, "solid facet of a vertex\n");
    for (int f = 0; f < 4; f++) {
        put_text(b, "  facet normal nan nan nan\n    outer loop\n");
        for (int k = 0; k < 3; k++) {
            const double *p = tetra_position[tetra_face[f][k]];
            put_text(b, "      vertex %e %s %e\n", p[0],
                     f == 1 && p[1] == 0 ? "-0.0" : (p[1] == 1 ? "1" : "0"), p[2]);
        }
        put_text(b, "    endloop\n  endfacet\n");
    }
    put_text(b, "endsolid facet of a vertex\n");
}

static inline void make_stl_binary(scan_bytes *b, const char *title) {
    char header[80] = "";
    (void)snprintf(header, sizeof header, "%s", title);
    put_bytes(b, header, 80);
    put_integer(b, 4, 4, false);
    for (int f = 0; f < 4; f++) {
        for (int k = 0; k < 3; k++)
            put_float(b, 0, false);
        for (int k = 0; k < 9; k++) {
            float x = (float)tetra_position[tetra_face[f][k / 3]][k % 3];
            put_float(b, f == 2 && x == 0 ? -0.0F : x, false);
        }
        put_integer(b, 0, 2, false);
    }
}

#endif
