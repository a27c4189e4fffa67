#include "deflate.h"
#include "memory.h"
#include "seal.h"
#include "store_private.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Datasets below this size are not worth compressing. */
enum { COMPRESS_FROM = 64 << 10 };

static herr_t keep_cause(unsigned n, const H5E_error2_t *error, void *text) {
    if (n == 0) (void)snprintf(text, 256, "%s", error->desc ? error->desc : "");
    return 0;
}

pc_status pc_store_fail(pc_store *store, pc_status status, const char *name, const char *what) {
    char cause[256] = "";
    (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_cause, cause);
    (void)H5Eclear2(H5E_DEFAULT);
    return pc_fail(store->ctx, status, "%s: '%s': %s%s%s%s", store->path, name, what,
                   cause[0] ? " (HDF5: " : "", cause, cause[0] ? ")" : "");
}

hid_t pc_store_file_type(pc_store_type type) {
    switch (type) {
    case PC_STORE_I8:
        return H5T_STD_I8LE;
    case PC_STORE_U8:
        return H5T_STD_U8LE;
    case PC_STORE_I32:
        return H5T_STD_I32LE;
    case PC_STORE_U32:
        return H5T_STD_U32LE;
    case PC_STORE_I64:
        return H5T_STD_I64LE;
    case PC_STORE_U64:
        return H5T_STD_U64LE;
    case PC_STORE_F32:
        return H5T_IEEE_F32LE;
    case PC_STORE_F64:
        break;
    }
    return H5T_IEEE_F64LE;
}

hid_t pc_store_memory_type(pc_store_type type) {
    switch (type) {
    case PC_STORE_I8:
        return H5T_NATIVE_INT8;
    case PC_STORE_U8:
        return H5T_NATIVE_UINT8;
    case PC_STORE_I32:
        return H5T_NATIVE_INT32;
    case PC_STORE_U32:
        return H5T_NATIVE_UINT32;
    case PC_STORE_I64:
        return H5T_NATIVE_INT64;
    case PC_STORE_U64:
        return H5T_NATIVE_UINT64;
    case PC_STORE_F32:
        return H5T_NATIVE_FLOAT;
    case PC_STORE_F64:
        break;
    }
    return H5T_NATIVE_DOUBLE;
}

size_t pc_store_type_size(pc_store_type type) {
    switch (type) {
    case PC_STORE_I8:
    case PC_STORE_U8:
        return 1;
    case PC_STORE_I32:
    case PC_STORE_U32:
    case PC_STORE_F32:
        return 4;
    case PC_STORE_I64:
    case PC_STORE_U64:
    case PC_STORE_F64:
        break;
    }
    return 8;
}

static pc_status make_store(pc_store **store, pc_context *ctx, const char *path) {
    pc_status status = PC_OK;
    pc_store *made = NULL;
    *store = NULL;
    /* The library would print its errors; ours go into one message. */
    (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    PC_TRY(pc_new(&made, ctx, 1));
    *made = (pc_store){.ctx = ctx, .file = H5I_INVALID_HID, .group_list = H5I_INVALID_HID};
    PC_TRY(pc_new(&made->path, ctx, strlen(path) + 1));
    memcpy(made->path, path, strlen(path) + 1);
    *store = made;
done:
    if (status != PC_OK) pc_free(ctx, made);
    return status;
}

static void free_store(pc_store *store) {
    if (store->file >= 0) (void)H5Fclose(store->file);
    if (store->group_list >= 0) (void)H5Pclose(store->group_list);
    pc_free(store->ctx, store->path);
    pc_free(store->ctx, store->partial);
    pc_free(store->ctx, store);
}

void pc_store_close(pc_store *store) {
    if (!store) return;
    if (store->file >= 0) (void)H5Fclose(store->file);
    store->file = H5I_INVALID_HID;
    if (store->partial) (void)unlink(store->partial);
    free_store(store);
}

/* Version 1.8 bounds: superblock and headers with checksums that all readers of the last 15 years know. Locks
 * are off, since they fail on network file systems and nobody opens a partial file. */
static hid_t access_list(void) {
    hid_t list = H5Pcreate(H5P_FILE_ACCESS);
    if (list < 0) return list;
    if (H5Pset_libver_bounds(list, H5F_LIBVER_V18, H5F_LIBVER_V18) < 0 ||
        H5Pset_fclose_degree(list, H5F_CLOSE_STRONG) < 0 || H5Pset_file_locking(list, false, true) < 0) {
        (void)H5Pclose(list);
        return H5I_INVALID_HID;
    }
    return list;
}

static pc_status create_file(pc_store *store) {
    pc_status status = PC_OK;
    hid_t access = access_list(), creation = H5Pcreate(H5P_FILE_CREATE);
    store->group_list = H5Pcreate(H5P_GROUP_CREATE);
    if (access < 0 || creation < 0 || store->group_list < 0 || H5Pset_obj_track_times(creation, false) < 0 ||
        H5Pset_obj_track_times(store->group_list, false) < 0)
        PC_TRY(pc_store_fail(store, PC_E_BUG, "/", "cannot prepare an HDF5 file"));
    store->file = H5Fcreate(store->partial, H5F_ACC_TRUNC, creation, access);
    if (store->file < 0) PC_TRY(pc_store_fail(store, PC_E_IO, "/", "cannot create the file"));
done:
    if (access >= 0) (void)H5Pclose(access);
    if (creation >= 0) (void)H5Pclose(creation);
    return status;
}

pc_status pc_store_create(pc_store **store, pc_context *ctx, const char *path,
                          const pc_store_options *options) {
    const pc_store_options defaults = PC_STORE_DEFAULTS;
    if (!options) options = &defaults;
    *store = NULL;
    if (!options->force && access(path, F_OK) == 0)
        return pc_fail(ctx, PC_E_IO, "%s: the file is there already", path);
    pc_store *made = NULL;
    pc_status status = make_store(&made, ctx, path);
    if (status != PC_OK) return status;
    made->compress = options->compress;
    PC_TRY(pc_new(&made->partial, ctx, strlen(path) + sizeof ".partial"));
    (void)snprintf(made->partial, strlen(path) + sizeof ".partial", "%s.partial", path);
    PC_TRY(create_file(made));
    PC_TRY(pc_store_set_text(made, "/", "format", PC_STORE_FORMAT));
    PC_TRY(pc_store_set_int(made, "/", "version", PC_STORE_VERSION));
    *store = made;
done:
    if (status != PC_OK) pc_store_close(made);
    return status;
}

pc_status pc_store_commit(pc_store **store) {
    pc_status status = PC_OK;
    pc_store *s = *store;
    *store = NULL;
    if (H5Fflush(s->file, H5F_SCOPE_GLOBAL) < 0)
        PC_TRY(pc_store_fail(s, PC_E_IO, "/", "cannot write the file"));
    herr_t closed = H5Fclose(s->file);
    s->file = H5I_INVALID_HID;
    if (closed < 0) PC_TRY(pc_store_fail(s, PC_E_IO, "/", "cannot close the file"));
    PC_TRY(pc_seal_write(s->ctx, s->partial));
    PC_TRY(pc_seal_publish(s->ctx, s->partial, s->path));
    pc_free(s->ctx, s->partial);
    s->partial = NULL;
done:
    pc_store_close(s);
    return status;
}

static pc_status check_format(pc_store *store) {
    pc_status status = PC_OK;
    char *format = NULL;
    int64_t version = 0;
    PC_TRY(pc_store_get_text(&format, store, "/", "format"));
    PC_TRY(pc_store_get_int(&version, store, "/", "version"));
    if (strcmp(format, PC_STORE_FORMAT) != 0)
        PC_TRY(pc_store_fail(store, PC_E_FORMAT, "/", "not a file of Percale"));
    if (version != PC_STORE_VERSION)
        PC_TRY(pc_fail(store->ctx, PC_E_FORMAT, "%s: format version %lld, this program reads %d", store->path,
                       (long long)version, PC_STORE_VERSION));
done:
    pc_free(store->ctx, format);
    return status;
}

pc_status pc_store_open(pc_store **store, pc_context *ctx, const char *path) {
    pc_store *made = NULL;
    hid_t access = H5I_INVALID_HID;
    pc_status status = make_store(&made, ctx, path);
    *store = NULL;
    if (status != PC_OK) return status;
    PC_TRY(pc_seal_check(&made->bytes, ctx, path));
    access = access_list();
    made->file = access < 0 ? H5I_INVALID_HID : H5Fopen(path, H5F_ACC_RDONLY, access);
    if (made->file < 0) PC_TRY(pc_store_fail(made, PC_E_FORMAT, "/", "not a readable HDF5 file"));
    PC_TRY(check_format(made));
    *store = made;
    made = NULL;
done:
    if (access >= 0) (void)H5Pclose(access);
    pc_store_close(made);
    return status;
}

pc_context *pc_store_context(const pc_store *store) {
    return store->ctx;
}

const char *pc_store_path(const pc_store *store) {
    return store->path;
}

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

static pc_status write_data(pc_store *store, hid_t dataset, const char *name, pc_store_type type,
                            size_t count, const void *data) {
    if (count == 0) return PC_OK;
    if (H5Dwrite(dataset, pc_store_memory_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
        return pc_store_fail(store, PC_E_IO, name, "cannot write");
    return PC_OK;
}

pc_status pc_store_put(pc_store *store, const char *name, pc_store_type type, int rank, const size_t *dims,
                       const void *data, const char *units, const char *description) {
    pc_status status = PC_OK;
    hid_t parent = H5I_INVALID_HID, space = H5I_INVALID_HID, list = H5I_INVALID_HID,
          dataset = H5I_INVALID_HID;
    hsize_t sizes[PC_STORE_MAX_RANK], chunk[PC_STORE_MAX_RANK];
    size_t count = 1;
    const char *leaf = NULL;
    for (int k = 0; k < rank; k++)
        sizes[k] = dims[k], count *= dims[k];
    size_t bytes = count * pc_store_type_size(type);
    bool compress = store->compress && bytes >= COMPRESS_FROM;
    PC_TRY(open_parent(&parent, &leaf, store, name));
    space = H5Screate_simple(rank, sizes, NULL);
    list = H5Pcreate(H5P_DATASET_CREATE);
    if (space < 0 || list < 0 || H5Pset_obj_track_times(list, false) < 0 ||
        H5Pset_fill_time(list, H5D_FILL_TIME_NEVER) < 0)
        PC_TRY(pc_store_fail(store, PC_E_BUG, name, "cannot describe the dataset"));
    if (compress) {
        pc_deflate_chunk(chunk, rank, sizes, pc_store_type_size(type));
        if (H5Pset_chunk(list, rank, chunk) < 0 || H5Pset_shuffle(list) < 0 || H5Pset_deflate(list, 1) < 0)
            PC_TRY(pc_store_fail(store, PC_E_BUG, name, "cannot set up the compression"));
    }
    dataset = H5Dcreate2(parent, leaf, pc_store_file_type(type), space, H5P_DEFAULT, list, H5P_DEFAULT);
    if (dataset < 0) PC_TRY(pc_store_fail(store, PC_E_IO, name, "cannot create the dataset"));
    if (compress)
        PC_TRY(pc_deflate_write(store, dataset, name, bytes, (size_t)chunk[0], (size_t)sizes[0],
                                pc_store_type_size(type), data));
    else
        PC_TRY(write_data(store, dataset, name, type, count, data));
    PC_TRY(pc_store_set_text(store, name, "units", units));
    PC_TRY(pc_store_set_text(store, name, "description", description));
done:
    if (dataset >= 0 && H5Dclose(dataset) < 0 && status == PC_OK)
        status = pc_store_fail(store, PC_E_IO, name, "cannot write");
    if (list >= 0) (void)H5Pclose(list);
    if (space >= 0) (void)H5Sclose(space);
    if (parent >= 0) (void)H5Gclose(parent);
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
done:
    if (parent >= 0) (void)H5Gclose(parent);
    return status;
}
