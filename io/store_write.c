#include "deflate.h"
#include "store_private.h"
#include <assert.h>
#include <string.h>

/* Datasets below this size are not worth compressing. */
enum { COMPRESS_FROM = 64 << 10 };

/* Whether every link on the way exists: H5Lexists fails where a parent is missing. */
bool pc_store_has(pc_store *store, const char *name) {
    char part[256];
    size_t length = strlen(name);
    if (length == 0 || length >= sizeof part) return false;
    for (size_t i = 1; i <= length; i++) {
        if (name[i] != '/' && name[i] != '\0') continue;
        memcpy(part, name, i);
        part[i] = '\0';
        if (H5Lexists(store->file, part, H5P_DEFAULT) <= 0) return false;
    }
    return true;
}

pc_status pc_store_group(hid_t *group, pc_store *store, const char *name) {
    hid_t at = H5Gopen2(store->file, "/", H5P_DEFAULT);
    char part[256];
    while (at >= 0 && *name) {
        size_t length = strcspn(name, "/");
        if (length >= sizeof part) break;
        memcpy(part, name, length);
        part[length] = '\0';
        name += length + (name[length] == '/');
        if (length == 0) continue;
        hid_t next = H5Lexists(at, part, H5P_DEFAULT) > 0
                         ? H5Gopen2(at, part, H5P_DEFAULT)
                         : H5Gcreate2(at, part, H5P_DEFAULT, store->group_list, H5P_DEFAULT);
        (void)H5Gclose(at);
        at = next;
    }
    *group = at;
    if (at >= 0 && *name == '\0') return PC_OK;
    if (at >= 0) (void)H5Gclose(at);
    *group = H5I_INVALID_HID;
    return pc_store_fail(store, PC_E_IO, name, "cannot make the group");
}

pc_status pc_store_object(hid_t *object, pc_store *store, const char *name) {
    bool root = strcmp(name, "/") == 0 || name[0] == '\0';
    if (store->partial && !root && !pc_store_has(store, name)) return pc_store_group(object, store, name);
    *object = H5Oopen(store->file, root ? "/" : name, H5P_DEFAULT);
    return *object >= 0 ? PC_OK : pc_store_fail(store, PC_E_FORMAT, name, "missing");
}

/* Makes the group that `name` lies in and returns the part after the last slash. */
static pc_status open_parent(hid_t *parent, const char **leaf, pc_store *store, const char *name) {
    char folder[256] = "";
    const char *slash = strrchr(name, '/');
    size_t length = slash ? (size_t)(slash - name) : 0;
    if (length >= sizeof folder) return pc_store_fail(store, PC_E_BUG, name, "the name is too long");
    memcpy(folder, name, length);
    *leaf = slash ? slash + 1 : name;
    return pc_store_group(parent, store, folder);
}

typedef struct shape {
    size_t element_bytes, bytes;
    hsize_t sizes[PC_STORE_MAX_RANK], chunk[PC_STORE_MAX_RANK];
    int rank;
    bool compress;
} shape;

static shape shape_of(const pc_store *store, pc_store_type type, int rank, const size_t *dims) {
    shape s = {.rank = rank, .element_bytes = pc_store_type_size(type)};
    assert(rank >= 1 && rank <= PC_STORE_MAX_RANK);
    s.bytes = s.element_bytes;
    for (int k = 0; k < rank; k++)
        s.sizes[k] = dims[k], s.bytes *= dims[k];
    s.compress = store->compress && s.bytes >= COMPRESS_FROM;
    if (s.compress) pc_deflate_chunk(s.chunk, rank, s.sizes, s.element_bytes);
    return s;
}

static pc_status create_dataset(hid_t *dataset, pc_store *store, const char *name, pc_store_type type,
                                const shape *s) {
    pc_status status = PC_OK;
    hid_t parent = H5I_INVALID_HID, space = H5Screate_simple(s->rank, s->sizes, NULL);
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    const char *leaf = NULL;
    PC_TRY(open_parent(&parent, &leaf, store, name));
    if (space < 0 || list < 0 || H5Pset_obj_track_times(list, false) < 0 ||
        H5Pset_fill_time(list, H5D_FILL_TIME_NEVER) < 0)
        PC_TRY(pc_store_fail(store, PC_E_BUG, name, "cannot describe the dataset"));
    if (s->compress && (H5Pset_chunk(list, s->rank, s->chunk) < 0 || H5Pset_shuffle(list) < 0 ||
                        H5Pset_deflate(list, 1) < 0))
        PC_TRY(pc_store_fail(store, PC_E_BUG, name, "cannot set up the compression"));
    *dataset = H5Dcreate2(parent, leaf, pc_store_file_type(type), space, H5P_DEFAULT, list, H5P_DEFAULT);
    if (*dataset < 0) PC_TRY(pc_store_fail(store, PC_E_IO, name, "cannot create the dataset"));
done:
    if (list >= 0) (void)H5Pclose(list);
    if (space >= 0) (void)H5Sclose(space);
    if (parent >= 0) (void)H5Gclose(parent);
    return status;
}

pc_status pc_store_put(pc_store *store, const char *name, pc_store_type type, int rank, const size_t *dims,
                       const void *data, const char *units, const char *description) {
    pc_status status = PC_OK;
    hid_t dataset = H5I_INVALID_HID;
    const shape s = shape_of(store, type, rank, dims);
    PC_TRY(create_dataset(&dataset, store, name, type, &s));
    if (s.compress)
        PC_TRY(pc_deflate_write(store, dataset, name, s.bytes, (size_t)s.chunk[0], (size_t)s.sizes[0],
                                s.element_bytes, data));
    else if (s.bytes > 0 &&
             H5Dwrite(dataset, pc_store_memory_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
        PC_TRY(pc_store_fail(store, PC_E_IO, name, "cannot write"));
    PC_TRY(pc_store_set_text(store, name, "units", units));
    PC_TRY(pc_store_set_text(store, name, "description", description));
    PC_TRY(pc_store_check_written(store));
done:
    if (dataset >= 0) (void)H5Dclose(dataset);
    return status;
}

pc_status pc_store_copy(pc_store *store, pc_store *from, const char *name) {
    pc_status status = PC_OK;
    hid_t parent = H5I_INVALID_HID;
    const char *leaf = NULL;
    PC_TRY(open_parent(&parent, &leaf, store, name));
    if (!pc_store_has(from, name)) PC_TRY(pc_store_fail(from, PC_E_FORMAT, name, "missing"));
    if (H5Ocopy(from->file, name, parent, leaf, H5P_DEFAULT, H5P_DEFAULT) < 0)
        PC_TRY(pc_store_fail(store, PC_E_IO, name, "cannot copy"));
    PC_TRY(pc_store_check_written(store));
done:
    if (parent >= 0) (void)H5Gclose(parent);
    return status;
}
