#include "memory.h"
#include "store_private.h"
#include <stdlib.h>
#include <string.h>

/* Writes one attribute in place of an old one of that name. */
static pc_status set_attribute(pc_store *store, const char *object_name, const char *name, hid_t file_type,
                               hid_t memory_type, hid_t space, const void *value) {
    pc_status status = PC_OK;
    hid_t object = H5I_INVALID_HID, attribute = H5I_INVALID_HID;
    PC_TRY(pc_store_object(&object, store, object_name));
    if (H5Aexists(object, name) > 0 && H5Adelete(object, name) < 0)
        PC_TRY(pc_store_fail(store, PC_E_IO, object_name, "cannot replace an attribute"));
    attribute = H5Acreate2(object, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute < 0 || H5Awrite(attribute, memory_type, value) < 0)
        PC_TRY(pc_store_fail(store, PC_E_IO, object_name, "cannot write an attribute"));
done:
    if (attribute >= 0) (void)H5Aclose(attribute);
    if (object >= 0) (void)H5Oclose(object);
    return status;
}

static pc_status set_scalar(pc_store *store, const char *object, const char *name, hid_t file_type,
                            hid_t memory_type, const void *value) {
    hid_t space = H5Screate(H5S_SCALAR);
    pc_status status = space < 0 ? pc_store_fail(store, PC_E_BUG, object, "cannot describe an attribute")
                                 : set_attribute(store, object, name, file_type, memory_type, space, value);
    if (space >= 0) (void)H5Sclose(space);
    return status;
}

/* UTF-8 of the given length, or of any length where it is H5T_VARIABLE (h5py gives such attributes as str).
 */
static hid_t text_type(size_t length, H5T_cset_t characters) {
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type < 0) return type;
    if (H5Tset_size(type, length) >= 0 && H5Tset_cset(type, characters) >= 0) return type;
    (void)H5Tclose(type);
    return H5I_INVALID_HID;
}

pc_status pc_store_set_text(pc_store *store, const char *object, const char *name, const char *value) {
    hid_t type = text_type(H5T_VARIABLE, H5T_CSET_UTF8);
    pc_status status = type < 0 ? pc_store_fail(store, PC_E_BUG, object, "cannot describe an attribute")
                                : set_scalar(store, object, name, type, type, (const void *)&value);
    if (type >= 0) (void)H5Tclose(type);
    return status;
}

pc_status pc_store_set_label(pc_store *store, const char *object, const char *name, const char *value) {
    hid_t type = text_type(strlen(value) ? strlen(value) : 1, H5T_CSET_ASCII);
    pc_status status = type < 0 ? pc_store_fail(store, PC_E_BUG, object, "cannot describe an attribute")
                                : set_scalar(store, object, name, type, type, value);
    if (type >= 0) (void)H5Tclose(type);
    return status;
}

pc_status pc_store_set_int(pc_store *store, const char *object, const char *name, int64_t value) {
    return set_scalar(store, object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

pc_status pc_store_set_real(pc_store *store, const char *object, const char *name, double value) {
    return set_scalar(store, object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

pc_status pc_store_set_ints(pc_store *store, const char *object, const char *name, size_t count,
                            const int64_t *value) {
    hsize_t size = count;
    hid_t space = H5Screate_simple(1, &size, NULL);
    pc_status status =
        space < 0 ? pc_store_fail(store, PC_E_BUG, object, "cannot describe an attribute")
                  : set_attribute(store, object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, space, value);
    if (space >= 0) (void)H5Sclose(space);
    return status;
}

static pc_status attribute_failed(pc_store *store, const char *object, const char *name, const char *what) {
    (void)H5Eclear2(H5E_DEFAULT);
    return pc_fail(store->ctx, PC_E_FORMAT, "%s: '%s': attribute '%s' %s", store->path, object, name, what);
}

/* Opens an attribute that must be a scalar. */
static pc_status open_scalar(hid_t *attribute, hid_t *type, pc_store *store, const char *object_name,
                             const char *name) {
    pc_status status = PC_OK;
    hid_t object = H5I_INVALID_HID, space = H5I_INVALID_HID;
    PC_TRY(pc_store_object(&object, store, object_name));
    *attribute = H5Aopen(object, name, H5P_DEFAULT);
    if (*attribute < 0) PC_TRY(attribute_failed(store, object_name, name, "is missing"));
    space = H5Aget_space(*attribute);
    *type = H5Aget_type(*attribute);
    if (space < 0 || *type < 0 || H5Sget_simple_extent_npoints(space) != 1)
        PC_TRY(attribute_failed(store, object_name, name, "is not a single value"));
done:
    if (space >= 0) (void)H5Sclose(space);
    if (object >= 0) (void)H5Oclose(object);
    return status;
}

static void close_scalar(hid_t attribute, hid_t type) {
    if (attribute >= 0) (void)H5Aclose(attribute);
    if (type >= 0) (void)H5Tclose(type);
}

static pc_status get_number(void *value, pc_store *store, const char *object, const char *name,
                            H5T_class_t class, hid_t memory_type) {
    pc_status status = PC_OK;
    hid_t attribute = H5I_INVALID_HID, type = H5I_INVALID_HID;
    PC_TRY(open_scalar(&attribute, &type, store, object, name));
    if (H5Tget_class(type) != class) PC_TRY(attribute_failed(store, object, name, "is of another type"));
    if (H5Aread(attribute, memory_type, value) < 0)
        PC_TRY(attribute_failed(store, object, name, "cannot be read"));
done:
    close_scalar(attribute, type);
    return status;
}

pc_status pc_store_get_int(int64_t *value, pc_store *store, const char *object, const char *name) {
    return get_number(value, store, object, name, H5T_INTEGER, H5T_NATIVE_INT64);
}

pc_status pc_store_get_real(double *value, pc_store *store, const char *object, const char *name) {
    return get_number(value, store, object, name, H5T_FLOAT, H5T_NATIVE_DOUBLE);
}

pc_status pc_store_get_text(char **value, pc_store *store, const char *object, const char *name) {
    pc_status status = PC_OK;
    hid_t attribute = H5I_INVALID_HID, type = H5I_INVALID_HID;
    char *text = NULL;
    *value = NULL;
    PC_TRY(open_scalar(&attribute, &type, store, object, name));
    if (H5Tget_class(type) != H5T_STRING) PC_TRY(attribute_failed(store, object, name, "is not a text"));
    if (H5Tis_variable_str(type) > 0) {
        if (H5Aread(attribute, type, (void *)&text) < 0)
            PC_TRY(attribute_failed(store, object, name, "cannot be read"));
        size_t length = text ? strlen(text) : 0;
        PC_TRY(pc_new(value, store->ctx, length + 1));
        if (text) memcpy(*value, text, length);
    } else {
        PC_TRY(pc_new(value, store->ctx, H5Tget_size(type) + 1));
        if (H5Aread(attribute, type, *value) < 0)
            PC_TRY(attribute_failed(store, object, name, "cannot be read"));
    }
done:
    if (text) (void)H5free_memory(text);
    close_scalar(attribute, type);
    if (status != PC_OK) {
        pc_free(store->ctx, *value);
        *value = NULL;
    }
    return status;
}

typedef struct copy_job {
    pc_store *to;
    hid_t object;
} copy_job;

static herr_t copy_attribute(hid_t from, const char *name, const H5A_info_t *info, void *user) {
    (void)info;
    const copy_job *job = user;
    hid_t old = H5Aopen(from, name, H5P_DEFAULT), type = H5Aget_type(old), space = H5Aget_space(old);
    hid_t copy = H5I_INVALID_HID;
    hssize_t count = H5Sget_simple_extent_npoints(space);
    size_t size = H5Tget_size(type);
    unsigned char *value = NULL;
    herr_t result = -1;
    if (count >= 0 && size > 0 &&
        pc_alloc_bytes((void **)&value, job->to->ctx, (size_t)count, size) ==
            PC_OK && /* large enough for any */
        H5Aread(old, type, value) >= 0) {
        if (H5Aexists(job->object, name) > 0) (void)H5Adelete(job->object, name);
        copy = H5Acreate2(job->object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
        result = copy < 0 ? -1 : H5Awrite(copy, type, value);
        (void)H5Dvlen_reclaim(type, space, H5P_DEFAULT, value);
    }
    pc_free(job->to->ctx, value);
    if (copy >= 0) (void)H5Aclose(copy);
    if (space >= 0) (void)H5Sclose(space);
    if (type >= 0) (void)H5Tclose(type);
    if (old >= 0) (void)H5Aclose(old);
    return result < 0 ? -1 : 0;
}

pc_status pc_store_copy_attributes(pc_store *store, const char *object, pc_store *from, const char *source) {
    pc_status status = PC_OK;
    hid_t old = H5I_INVALID_HID;
    copy_job job = {.to = store, .object = H5I_INVALID_HID};
    PC_TRY(pc_store_object(&old, from, source));
    PC_TRY(pc_store_object(&job.object, store, object));
    if (H5Aiterate2(old, H5_INDEX_NAME, H5_ITER_INC, NULL, copy_attribute, &job) < 0)
        PC_TRY(pc_store_fail(store, PC_E_IO, object, "cannot copy the attributes"));
done:
    if (job.object >= 0) (void)H5Oclose(job.object);
    if (old >= 0) (void)H5Oclose(old);
    return status;
}
