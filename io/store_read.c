#include "memory.h"
#include "store_private.h"
#include <stdio.h>
#include <string.h>

/* zlib packs at most 1032 to 1; a dataset that claims more does not fit in its file. */
enum { DEFLATE_LIMIT = 1040 };

/* Type, rank and sizes as demanded; `bytes` is what the array takes. */
static pc_status check_shape(size_t *bytes, pc_store *store, const char *name, hid_t dataset,
                             pc_store_type type, int rank, size_t *dims) {
    pc_status status = PC_OK;
    hsize_t sizes[PC_STORE_MAX_RANK] = {0};
    hid_t space = H5Dget_space(dataset), found = H5Dget_type(dataset);
    if (space < 0 || found < 0) PC_TRY(pc_store_fail(store, PC_E_FORMAT, name, "cannot be read"));
    if (H5Tequal(found, pc_store_file_type(type)) <= 0)
        PC_TRY(pc_store_fail(store, PC_E_FORMAT, name, "has another element type"));
    if (H5Sget_simple_extent_ndims(space) != rank || H5Sget_simple_extent_dims(space, sizes, NULL) != rank)
        PC_TRY(pc_store_fail(store, PC_E_FORMAT, name, "has another rank"));
    *bytes = pc_store_type_size(type);
    for (int k = 0; k < rank; k++) {
        if (dims[k] != PC_STORE_ANY && dims[k] != sizes[k])
            PC_TRY(pc_fail(store->ctx, PC_E_FORMAT, "%s: '%s': size %llu in direction %d, expected %zu",
                           store->path, name, (unsigned long long)sizes[k], k, dims[k]));
        dims[k] = sizes[k];
        if (__builtin_mul_overflow(*bytes, dims[k], bytes))
            PC_TRY(pc_store_fail(store, PC_E_FORMAT, name, "is larger than any file"));
    }
done:
    if (space >= 0) (void)H5Sclose(space);
    if (found >= 0) (void)H5Tclose(found);
    return status;
}

/* No large allocation on the word of a header. */
static pc_status check_storage(pc_store *store, const char *name, hid_t dataset, size_t bytes) {
    hid_t list = H5Dget_create_plist(dataset);
    H5D_layout_t layout = list < 0 ? H5D_LAYOUT_ERROR : H5Pget_layout(list);
    hsize_t stored = H5Dget_storage_size(dataset);
    if (list >= 0) (void)H5Pclose(list);
    bool fits = stored <= store->bytes;
    if (layout == H5D_CHUNKED)
        fits = fits && bytes / DEFLATE_LIMIT <= stored;
    else
        fits = fits && stored >= bytes && (layout == H5D_CONTIGUOUS || layout == H5D_COMPACT);
    return fits ? PC_OK : pc_store_fail(store, PC_E_FORMAT, name, "is larger than its file can hold");
}

pc_status pc_store_read(void **out, pc_store *store, const char *name, pc_store_type type, int rank,
                        size_t *dims) {
    pc_status status = PC_OK;
    hid_t dataset = H5I_INVALID_HID;
    size_t bytes;
    *out = NULL;
    if (!pc_store_has(store, name)) PC_TRY(pc_store_fail(store, PC_E_FORMAT, name, "missing"));
    dataset = H5Dopen2(store->file, name, H5P_DEFAULT);
    if (dataset < 0) PC_TRY(pc_store_fail(store, PC_E_FORMAT, name, "not a dataset"));
    PC_TRY(check_shape(&bytes, store, name, dataset, type, rank, dims));
    PC_TRY(check_storage(store, name, dataset, bytes));
    PC_TRY(pc_alloc_bytes(out, store->ctx, bytes, 1));
    if (bytes > 0 && H5Dread(dataset, pc_store_memory_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, *out) < 0)
        PC_TRY(pc_store_fail(store, PC_E_FORMAT, name, "cannot be read"));
done:
    if (dataset >= 0) (void)H5Dclose(dataset);
    if (status != PC_OK) {
        pc_free(store->ctx, *out);
        *out = NULL;
    }
    return status;
}

typedef struct walk {
    pc_store *store;
    pc_store_visitor *visit;
    void *user;
    pc_status status;
} walk;

static const char *type_name(hid_t type) {
    static const struct {
        pc_store_type type;
        const char *name;
    } names[] = {{PC_STORE_I8, "int8"},     {PC_STORE_U8, "uint8"},   {PC_STORE_I32, "int32"},
                 {PC_STORE_U32, "uint32"},  {PC_STORE_I64, "int64"},  {PC_STORE_U64, "uint64"},
                 {PC_STORE_F32, "float32"}, {PC_STORE_F64, "float64"}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (H5Tequal(type, pc_store_file_type(names[i].type)) > 0) return names[i].name;
    return "other";
}

/* The text of an attribute where there is one, else NULL. */
static pc_status optional_text(char **text, pc_store *store, hid_t object, const char *object_name,
                               const char *name) {
    *text = NULL;
    return H5Aexists(object, name) > 0 ? pc_store_get_text(text, store, object_name, name) : PC_OK;
}

static pc_status visit_dataset(walk *w, const char *name, hid_t object) {
    pc_status status = PC_OK;
    pc_store_entry entry = {.name = name};
    char *units = NULL, *description = NULL;
    hsize_t sizes[PC_STORE_MAX_RANK] = {0};
    hid_t space = H5Dget_space(object), type = H5Dget_type(object);
    int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    if (type < 0 || rank < 0 || rank > PC_STORE_MAX_RANK)
        PC_TRY(pc_store_fail(w->store, PC_E_FORMAT, name, "is no array of Percale"));
    (void)H5Sget_simple_extent_dims(space, sizes, NULL);
    PC_TRY(optional_text(&units, w->store, object, name, "units"));
    PC_TRY(optional_text(&description, w->store, object, name, "description"));
    entry.type = type_name(type);
    entry.rank = rank;
    for (int k = 0; k < rank; k++)
        entry.dims[k] = sizes[k];
    entry.stored_bytes = H5Dget_storage_size(object);
    entry.units = units ? units : "";
    entry.description = description ? description : "";
    PC_TRY(w->visit(w->user, &entry));
done:
    pc_free(w->store->ctx, units);
    pc_free(w->store->ctx, description);
    if (space >= 0) (void)H5Sclose(space);
    if (type >= 0) (void)H5Tclose(type);
    return status;
}

static herr_t visit_object(hid_t root, const char *name, const H5O_info_t *info, void *user) {
    walk *w = user;
    if (strcmp(name, ".") == 0) return 0;
    if (info->type == H5O_TYPE_GROUP) {
        w->status = w->visit(
            w->user,
            &(pc_store_entry){.name = name, .group = true, .type = "", .units = "", .description = ""});
    } else if (info->type == H5O_TYPE_DATASET) {
        hid_t object = H5Dopen2(root, name, H5P_DEFAULT);
        w->status = object < 0 ? pc_store_fail(w->store, PC_E_FORMAT, name, "cannot be opened")
                               : visit_dataset(w, name, object);
        if (object >= 0) (void)H5Dclose(object);
    }
    return w->status == PC_OK ? 0 : -1;
}

pc_status pc_store_visit(pc_store *store, pc_store_visitor *visit, void *user) {
    walk w = {.store = store, .visit = visit, .user = user, .status = PC_OK};
    herr_t walked = H5Ovisit2(store->file, H5_INDEX_NAME, H5_ITER_INC, visit_object, &w, H5O_INFO_BASIC);
    if (walked < 0 && w.status == PC_OK)
        return pc_store_fail(store, PC_E_FORMAT, "/", "cannot list the content");
    return w.status;
}
