#include "memory.h"
#include "seal.h"
#include "store_private.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

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
    *made = (pc_store){.ctx = ctx,
                       .file = H5I_INVALID_HID,
                       .group_list = H5I_INVALID_HID,
                       .driver = {.id = H5I_INVALID_HID, .file = -1}};
    PC_TRY(pc_new(&made->path, ctx, strlen(path) + 1));
    memcpy(made->path, path, strlen(path) + 1);
    *store = made;
done:
    if (status != PC_OK) pc_free(ctx, made);
    return status;
}

/* Closes what is open; whether all that was written has arrived is in driver.error. */
static void close_file(pc_store *store) {
    if (store->file >= 0) (void)H5Fclose(store->file);
    if (store->group_list >= 0) (void)H5Pclose(store->group_list);
    store->file = store->group_list = H5I_INVALID_HID;
    pc_store_driver_release(&store->driver);
    if (store->driver.file >= 0 && close(store->driver.file) != 0 && store->driver.error == 0)
        store->driver.error = errno;
    store->driver.file = -1;
}

void pc_store_close(pc_store *store) {
    if (!store) return;
    close_file(store);
    if (store->partial) (void)unlink(store->partial);
    pc_free(store->ctx, store->path);
    pc_free(store->ctx, store->partial);
    pc_free(store->ctx, store);
}

pc_status pc_store_check_written(pc_store *store) {
    if (store->driver.error == 0) return PC_OK;
    return pc_fail(store->ctx, PC_E_IO, "%s: cannot write: %s", store->path, strerror(store->driver.error));
}

/* Version 1.8 bounds: superblock and headers with checksums that all readers of the last 15 years know. Locks
 * are off, since they fail on network file systems and nobody opens a partial file. */
static hid_t access_list(pc_store_driver *driver) {
    hid_t list = H5Pcreate(H5P_FILE_ACCESS);
    if (list < 0) return list;
    if (H5Pset_libver_bounds(list, H5F_LIBVER_V18, H5F_LIBVER_V18) < 0 ||
        H5Pset_fclose_degree(list, H5F_CLOSE_STRONG) < 0 || H5Pset_file_locking(list, false, true) < 0 ||
        (driver && pc_store_driver_use(driver, list) < 0)) {
        (void)H5Pclose(list);
        return H5I_INVALID_HID;
    }
    return list;
}

static pc_status create_file(pc_store *store) {
    pc_status status = PC_OK;
    hid_t access = access_list(&store->driver), creation = H5Pcreate(H5P_FILE_CREATE);
    store->group_list = H5Pcreate(H5P_GROUP_CREATE);
    if (access < 0 || creation < 0 || store->group_list < 0 || H5Pset_obj_track_times(creation, false) < 0 ||
        H5Pset_obj_track_times(store->group_list, false) < 0)
        PC_TRY(pc_store_fail(store, PC_E_BUG, "/", "cannot prepare an HDF5 file"));
    store->driver.file = open(store->partial, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (store->driver.file < 0)
        PC_TRY(
            pc_fail(store->ctx, PC_E_IO, "%s: cannot create the file: %s", store->partial, strerror(errno)));
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
    close_file(s);
    PC_TRY(pc_store_check_written(s));
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
    access = access_list(NULL);
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
