/* Compressed chunks for a dataset, made in our own threads. The HDF5 library would encode one chunk after the
 * other; every reader takes these, for they are what its shuffle and deflate filters write. */
#ifndef PC_DEFLATE_H
#define PC_DEFLATE_H

#include "store_private.h"

/* Chunk sizes of about a megabyte: some rows of all columns. They depend on the dataset only. */
void pc_deflate_chunk(hsize_t *chunk, int rank, const hsize_t *sizes, size_t element_bytes);
/* Writes `bytes` bytes in `rows` rows, `chunk_rows` to a chunk; chunks are encoded with the threads at hand
 * and written in order. PC_E_NOMEM, PC_E_IO, PC_E_INTERRUPT. */
pc_status pc_deflate_write(pc_store *store, hid_t dataset, const char *name, size_t bytes, size_t chunk_rows,
                           size_t rows, size_t element_bytes, const void *data);

#endif
