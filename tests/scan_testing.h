/* What the readers' tests share: read bytes under a name, and compare with what should come out. */
#ifndef PC_SCAN_TESTING_H
#define PC_SCAN_TESTING_H

#include "scan.h"
#include "scan_bytes.h"
#include "testing.h"

static inline void read_fine(pc_mesh *mesh, pc_scan_info *info, pc_context *ctx, const char *name,
                             const scan_bytes *bytes) {
    assert_ok(ctx, pc_scan_read_bytes(mesh, info, ctx, name, bytes->data, bytes->size));
}

static inline void is_tetrahedron(const pc_mesh *mesh) {
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->face_count, 4);
    for (size_t f = 0; f < 4; f++)
        for (size_t k = 0; k < 3; k++) {
            pc_index v = mesh->triangle[3 * f + k];
            assert_true(v < 4);
            for (size_t c = 0; c < 3; c++)
                assert_true(mesh->position[3 * (size_t)v + c] == tetra_position[tetra_face[f][k]][c]);
        }
}

static inline void reads_tetrahedron(pc_context *ctx, const char *name, const scan_bytes *bytes) {
    pc_mesh mesh;
    pc_scan_info info;
    read_fine(&mesh, &info, ctx, name, bytes);
    is_tetrahedron(&mesh);
    pc_mesh_free(&mesh, ctx);
}

/* The file is refused, nothing stays allocated, and the message holds all of `parts` (separated by '|'). */
static inline void is_refused(pc_context *ctx, const char *name, const char *data, size_t size,
                              const char *parts) {
    pc_mesh mesh;
    pc_scan_info info;
    char part[256];
    size_t before = pc_memory_used(ctx);
    pc_context_clear_message(ctx);
    pc_memory_reset_peak(ctx);
    pc_status status = pc_scan_read_bytes(&mesh, &info, ctx, name, data, size);
    if (status != PC_E_FORMAT) fail_msg("%s for a file that should say %s", pc_status_name(status), parts);
    assert_null(mesh.position);
    assert_null(mesh.triangle);
    assert_int_equal(pc_memory_used(ctx), before);
    if (pc_memory_peak(ctx) > 40 * size + (1 << 20))
        fail_msg("%zu bytes for a file of %zu", pc_memory_peak(ctx), size);
    for (const char *p = parts; *p;) {
        size_t n = strcspn(p, "|");
        (void)snprintf(part, sizeof part, "%.*s", (int)n, p);
        if (!strstr(pc_context_message(ctx), part))
            fail_msg("\"%s\" lacks \"%s\"", pc_context_message(ctx), part);
        p += n + (p[n] == '|');
    }
    pc_context_clear_message(ctx);
}

static inline void text_is_refused(pc_context *ctx, const char *name, const char *text, const char *parts) {
    is_refused(ctx, name, text, strlen(text), parts);
}

/* `bytes` with the first `from` replaced by `to`. */
static inline void replaced_is_refused(pc_context *ctx, const char *name, const scan_bytes *bytes,
                                       const char *from, const char *to, const char *parts) {
    scan_bytes changed = {.size = 0};
    size_t n = strlen(from);
    size_t at = 0;
    while (at + n <= bytes->size && memcmp(bytes->data + at, from, n) != 0)
        at++;
    assert_true(at + n <= bytes->size);
    put_bytes(&changed, bytes->data, at);
    put_text(&changed, "%s", to);
    put_bytes(&changed, bytes->data + at + n, bytes->size - at - n);
    is_refused(ctx, name, changed.data, changed.size, parts);
}

#define scan_test(name) cmocka_unit_test_setup_teardown(name, make_context, free_context)

#endif
