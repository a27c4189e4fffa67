#include "deflate.h"
#include "memory.h"
#include <libdeflate.h>
#include <string.h>

enum { CHUNK_BYTES = 1 << 20, BATCH = 16, LEVEL = 1 };

void pc_deflate_chunk(hsize_t *chunk, int rank, const hsize_t *sizes, size_t element_bytes) {
    hsize_t row = element_bytes;
    for (int k = 1; k < rank; k++)
        row *= chunk[k] = sizes[k];
    hsize_t rows = row < CHUNK_BYTES ? CHUNK_BYTES / row : 1;
    chunk[0] = rows < sizes[0] ? rows : sizes[0];
}

/* A batch of chunks in work: the whole is bounded, whatever the size of the dataset. */
typedef struct batch {
    size_t chunk_bytes, room;
    size_t packed_bytes[BATCH];
    unsigned char *plain;  /* BATCH chunks, bytes sorted by significance, the last one filled up with zeros */
    unsigned char *packed; /* BATCH times room */
    struct libdeflate_compressor *compressor[BATCH];
} batch;

static void batch_free(batch *b, pc_context *ctx) {
    pc_free(ctx, b->plain);
    pc_free(ctx, b->packed);
    for (int i = 0; i < BATCH; i++)
        libdeflate_free_compressor(b->compressor[i]);
}

static pc_status batch_make(batch *b, pc_context *ctx, size_t chunk_bytes) {
    pc_status status = PC_OK;
    *b = (batch){.chunk_bytes = chunk_bytes};
    for (int i = 0; i < BATCH; i++)
        if (!(b->compressor[i] = libdeflate_alloc_compressor(LEVEL)))
            PC_TRY(pc_fail(ctx, PC_E_NOMEM, "out of memory for compression"));
    b->room = libdeflate_zlib_compress_bound(b->compressor[0], chunk_bytes);
    PC_TRY(pc_new(&b->plain, ctx, BATCH * chunk_bytes));
    PC_TRY(pc_new(&b->packed, ctx, BATCH * b->room));
done:
    if (status != PC_OK) batch_free(b, ctx);
    return status;
}

/* HDF5's shuffle filter: all first bytes, then all second bytes, ... */
static void shuffle(unsigned char *to, const unsigned char *from, size_t count, size_t element_bytes) {
    for (size_t k = 0; k < element_bytes; k++)
        for (size_t i = 0; i < count; i++)
            to[k * count + i] = from[i * element_bytes + k];
}

static void encode(batch *b, int i, const unsigned char *from, size_t bytes, size_t element_bytes) {
    unsigned char *plain = b->plain + (size_t)i * b->chunk_bytes;
    unsigned char *packed = b->packed + (size_t)i * b->room;
    if (bytes <
        b->chunk_bytes) { /* the last chunk is stored whole; the room for its packed form holds the copy */
        memset(packed, 0, b->chunk_bytes);
        memcpy(packed, from, bytes);
        from = packed;
    }
    shuffle(plain, from, b->chunk_bytes / element_bytes, element_bytes);
    b->packed_bytes[i] = libdeflate_zlib_compress(b->compressor[i], plain, b->chunk_bytes, packed, b->room);
}

pc_status pc_deflate_write(pc_store *store, hid_t dataset, const char *name, size_t bytes, size_t chunk_rows,
                           size_t rows, size_t element_bytes, const void *data) {
    pc_status status = PC_OK;
    const unsigned char *from = data;
    size_t chunk_bytes = bytes / rows * chunk_rows, chunks = (rows + chunk_rows - 1) / chunk_rows;
    batch b;
    PC_TRY(batch_make(&b, store->ctx, chunk_bytes));
    for (size_t first = 0; first < chunks && status == PC_OK; first += BATCH) {
        int count = chunks - first < BATCH ? (int)(chunks - first) : BATCH;
#pragma omp parallel for schedule(static, 1)
        for (int i = 0; i < count; i++) {
            size_t at = (first + (size_t)i) * chunk_bytes;
            encode(&b, i, from + at, bytes - at < chunk_bytes ? bytes - at : chunk_bytes, element_bytes);
        }
        for (int i = 0; i < count && status == PC_OK; i++) {
            hsize_t corner[PC_STORE_MAX_RANK] = {(first + (size_t)i) * chunk_rows};
            if (b.packed_bytes[i] == 0)
                status = pc_store_fail(store, PC_E_BUG, name, "cannot compress");
            else if (H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, corner, b.packed_bytes[i],
                                    b.packed + (size_t)i * b.room) < 0)
                status = pc_store_fail(store, PC_E_IO, name, "cannot write");
        }
        if (status == PC_OK) status = pc_check_interrupt(store->ctx);
    }
    batch_free(&b, store->ctx);
done:
    return status;
}
