#include "gunzip.h"
#include "memory.h"
#include <libdeflate.h>
#include <string.h>

bool pc_gunzip_is(const char *data, size_t size) {
    return size >= 3 && memcmp(data, "\x1f\x8b\x08", 3) == 0;
}

/* What is being unpacked, and how far. */
typedef struct unpacker {
    pc_context *ctx;
    const char *name;
    struct libdeflate_decompressor *decompressor;
    char *out;
    size_t used, room;
} unpacker;

/* Deflate packs 1032 bytes into one at the best; most scans come to 2 to 8. */
enum { USUAL_RATIO = 8, BEST_RATIO = 1040, SPARE = 1 << 16 };

static pc_status make_room(unpacker *u, size_t room) {
    pc_status status = PC_OK;
    if (room <= u->room) return PC_OK;
    PC_TRY(pc_resize_bytes((void **)&u->out, u->ctx, room, 1));
    u->room = room;
done:
    return status;
}

/* The last four bytes are the size of the last member modulo 2^32: a hint, believed as far as it is usual. */
static size_t first_guess(const char *data, size_t size) {
    if (size < 18) return SPARE; /* shorter than the shortest member: the unpacking will say so */
    const unsigned char *p = (const unsigned char *)data + size - 4;
    size_t said = (size_t)p[0] | (size_t)p[1] << 8 | (size_t)p[2] << 16 | (size_t)p[3] << 24;
    size_t usual = USUAL_RATIO * size + SPARE;
    return said > 0 && said < usual ? said : usual;
}

static pc_status unpack_member(unpacker *u, size_t *taken, const char *data, size_t size, size_t offset) {
    pc_status status = PC_OK;
    for (;;) {
        size_t given = 0;
        enum libdeflate_result result = libdeflate_gzip_decompress_ex(
            u->decompressor, data, size, u->out + u->used, u->room - u->used, taken, &given);
        if (result == LIBDEFLATE_SUCCESS) {
            u->used += given;
            return PC_OK;
        }
        if (result != LIBDEFLATE_INSUFFICIENT_SPACE || (u->room - u->used) / BEST_RATIO > size)
            return pc_fail(
                u->ctx, PC_E_FORMAT,
                "%s: byte %zu: the gzip data is damaged or truncated: get the file anew (gzip -t tests it)",
                u->name, offset);
        PC_TRY(pc_check_interrupt(u->ctx));
        PC_TRY(make_room(u, 3 * (u->room - u->used) + SPARE + u->used));
    }
done:
    return status;
}

pc_status pc_gunzip(char **out, size_t *out_size, pc_context *ctx, const char *name, const char *data,
                    size_t size) {
    pc_status status = PC_OK;
    unpacker u = {.ctx = ctx, .name = name, .decompressor = libdeflate_alloc_decompressor()};
    size_t offset = 0;
    if (!u.decompressor) PC_TRY(pc_fail(ctx, PC_E_NOMEM, "out of memory: no room to unpack %s", name));
    PC_TRY(make_room(&u, first_guess(data, size)));
    while (offset < size && pc_gunzip_is(data + offset, size - offset)) {
        size_t taken = 0;
        PC_TRY(unpack_member(&u, &taken, data + offset, size - offset, offset));
        offset += taken;
    }
    if (offset < size)
        pc_log(ctx, PC_LOG_WARNING, "%s: %zu bytes behind the gzip data are ignored", name, size - offset);
    *out = u.out;
    *out_size = u.used;
    u.out = NULL;
done:
    libdeflate_free_decompressor(u.decompressor);
    pc_free(ctx, u.out);
    return status;
}
