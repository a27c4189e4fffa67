/* Arrays with names in an HDF5 file: what stages leave for each other and for the user.
 *
 * A file is written beside its final name, flushed, sealed (seal.h) and renamed, so that a reader meets all
 * of it or nothing. Equal calls give equal bytes: no times are kept, nothing depends on threads. Files that
 * have no right seal are refused before the HDF5 library sees them. The library has global state: use stores
 * from one thread at a time.
 *
 * Names are paths such as "field/normal"; the groups on the way are made. Every message names file and
 * dataset. */
#ifndef PC_STORE_H
#define PC_STORE_H

#include "context.h"

typedef struct pc_store pc_store;

#define PC_STORE_FORMAT  "percale"
#define PC_STORE_VERSION 1
#define PC_STORE_ANY     SIZE_MAX

enum { PC_STORE_MAX_RANK = 4 };

typedef enum pc_store_type {
    PC_STORE_I8,
    PC_STORE_U8,
    PC_STORE_I32,
    PC_STORE_U32,
    PC_STORE_I64,
    PC_STORE_U64,
    PC_STORE_F32,
    PC_STORE_F64
} pc_store_type;

typedef struct pc_store_options {
    bool force;    /* replace a file that is there */
    bool compress; /* shuffle + deflate 1 for the large datasets */
} pc_store_options;
#define PC_STORE_DEFAULTS                                                                                    \
    { .force = false, .compress = false }

/* Starts a file that will be called `path`. Until the commit it is `path`.partial, which a later attempt
 * overwrites. Root attributes format and version are written. PC_E_IO where the file is there already (and
 * not `force`) or cannot be written. `options` may be NULL. */
pc_status pc_store_create(pc_store **store, pc_context *ctx, const char *path,
                          const pc_store_options *options);
/* Writes one array, row-major. `units`: "model" for lengths of the user's frame, "1" for none. PC_E_IO,
 * PC_E_NOMEM. */
pc_status pc_store_put(pc_store *store, const char *name, pc_store_type type, int rank, const size_t *dims,
                       const void *data, const char *units, const char *description);
/* Attributes of a group (made where missing) or dataset; "/" is the root. An old value is replaced. */
pc_status pc_store_set_text(pc_store *store, const char *object, const char *name, const char *value);
pc_status pc_store_set_int(pc_store *store, const char *object, const char *name, int64_t value);
pc_status pc_store_set_real(pc_store *store, const char *object, const char *name, double value);
/* For VTK: 64-bit integers as an array; text as bytes of fixed length. */
pc_status pc_store_set_ints(pc_store *store, const char *object, const char *name, size_t count,
                            const int64_t *value);
pc_status pc_store_set_label(pc_store *store, const char *object, const char *name, const char *value);
/* Copies a group or dataset, with all below it, from `from` under the same name. */
pc_status pc_store_copy(pc_store *store, pc_store *from, const char *name);
/* Copies the attributes of the object `source` of `from` to `object`, which becomes a group where it is
 * missing. */
pc_status pc_store_copy_attributes(pc_store *store, const char *object, pc_store *from, const char *source);
/* Finishes the file under its name and frees the store, also on failure; then nothing has appeared under that
 * name.
 * `*store` becomes NULL. */
pc_status pc_store_commit(pc_store **store);

/* Opens a finished file for reading. PC_E_IO where it cannot be read; PC_E_FORMAT where it is damaged, cut
 * off, changed or foreign, or of a newer version. */
pc_status pc_store_open(pc_store **store, pc_context *ctx, const char *path);
bool pc_store_has(pc_store *store, const char *name);
/* Reads a dataset into a new array, which the caller frees with pc_free. `dims` gives the sizes that are
 * demanded, PC_STORE_ANY where any will do, and receives those found. PC_E_FORMAT where the dataset is
 * missing, of another type, rank or size, or larger than its file can hold. */
pc_status pc_store_read(void **out, pc_store *store, const char *name, pc_store_type type, int rank,
                        size_t *dims);
#define pc_store_get(out, store, name, type, rank, dims)                                                     \
    pc_store_read((void **)(out), (store), (name), (type), (rank), (dims))
/* The text is the caller's. PC_E_FORMAT where the attribute is missing or of another kind. */
pc_status pc_store_get_text(char **value, pc_store *store, const char *object, const char *name);
pc_status pc_store_get_int(int64_t *value, pc_store *store, const char *object, const char *name);
pc_status pc_store_get_real(double *value, pc_store *store, const char *object, const char *name);
/* Closes a store without finishing it; what was written is removed. NULL is fine. */
void pc_store_close(pc_store *store);

typedef struct pc_store_entry {
    const char *name; /* full path without the leading slash */
    bool group;       /* the rest is for datasets only */
    const char *type; /* "float64", "uint32", ..., "other" */
    int rank;
    size_t dims[PC_STORE_MAX_RANK];
    uint64_t stored_bytes;
    const char *units, *description; /* "" where missing */
} pc_store_entry;
typedef pc_status pc_store_visitor(void *user, const pc_store_entry *entry);
/* Calls `visit` for every group and dataset in the order of their names; its failure ends the walk. */
pc_status pc_store_visit(pc_store *store, pc_store_visitor *visit, void *user);

/* The context that the store was made with, and the name of its file. */
pc_context *pc_store_context(const pc_store *store);
const char *pc_store_path(const pc_store *store);

#endif
