#include "store_driver.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct open_file {
    H5FD_t base; /* must be first */
    pc_store_driver *driver;
    haddr_t end_allocated, end;
} open_file;

static void keep_error(pc_store_driver *driver, int error) {
    if (driver->error == 0) driver->error = error ? error : EIO;
}

/* The library opens a file once to look at it and again to create it, so the descriptor is the caller's. */
static H5FD_t *driver_open(const char *name, unsigned flags, hid_t access_list, haddr_t max_address) {
    (void)name, (void)flags, (void)max_address;
    pc_store_driver *const *info = H5Pget_driver_info(access_list);
    open_file *file = info ? calloc(1, sizeof *file) : NULL;
    struct stat status;
    if (!file) return NULL;
    file->driver = *info;
    file->end = fstat(file->driver->file, &status) == 0 ? (haddr_t)status.st_size : 0;
    return &file->base;
}

static herr_t driver_close(H5FD_t *file) {
    free(file);
    return 0;
}

static int driver_compare(const H5FD_t *one, const H5FD_t *two) {
    int a = ((const open_file *)one)->driver->file, b = ((const open_file *)two)->driver->file;
    return (a > b) - (a < b);
}

static herr_t driver_query(const H5FD_t *file, unsigned long *flags) {
    (void)file;
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
    return 0;
}

static haddr_t driver_get_eoa(const H5FD_t *file, H5FD_mem_t type) {
    (void)type;
    return ((const open_file *)file)->end_allocated;
}

static herr_t driver_set_eoa(H5FD_t *file, H5FD_mem_t type, haddr_t address) {
    (void)type;
    ((open_file *)file)->end_allocated = address;
    return 0;
}

static haddr_t driver_get_eof(const H5FD_t *file, H5FD_mem_t type) {
    (void)type;
    return ((const open_file *)file)->end;
}

/* What lies past the end, or cannot be read, is zero. */
static herr_t driver_read(H5FD_t *base, H5FD_mem_t type, hid_t list, haddr_t address, size_t size,
                          void *buffer) {
    (void)type, (void)list;
    open_file *file = (open_file *)base;
    unsigned char *to = buffer;
    while (size > 0) {
        ssize_t got = pread(file->driver->file, to, size, (off_t)address);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) keep_error(file->driver, errno);
        if (got <= 0) break;
        to += got, address += (haddr_t)got, size -= (size_t)got;
    }
    memset(to, 0, size);
    return 0;
}

static herr_t driver_write(H5FD_t *base, H5FD_mem_t type, hid_t list, haddr_t address, size_t size,
                           const void *buffer) {
    (void)type, (void)list;
    open_file *file = (open_file *)base;
    const unsigned char *from = buffer;
    if (address + size > file->end) file->end = address + size;
    while (size > 0 && file->driver->error == 0) {
        ssize_t put = pwrite(file->driver->file, from, size, (off_t)address);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) {
            keep_error(file->driver, put < 0 ? errno : ENOSPC);
            break;
        }
        from += put, address += (haddr_t)put, size -= (size_t)put;
    }
    return 0;
}

static herr_t driver_truncate(H5FD_t *base, hid_t list, hbool_t closing) {
    (void)list, (void)closing;
    open_file *file = (open_file *)base;
    if (file->end_allocated == file->end) return 0;
    file->end = file->end_allocated;
    if (file->driver->error == 0 && ftruncate(file->driver->file, (off_t)file->end) != 0)
        keep_error(file->driver, errno);
    return 0;
}

static const H5FD_class_t driver_class = {.name = "percale",
                                          .maxaddr = INT64_MAX,
                                          .fc_degree = H5F_CLOSE_STRONG,
                                          .fapl_size = sizeof(pc_store_driver *),
                                          .open = driver_open,
                                          .close = driver_close,
                                          .cmp = driver_compare,
                                          .query = driver_query,
                                          .get_eoa = driver_get_eoa,
                                          .set_eoa = driver_set_eoa,
                                          .get_eof = driver_get_eof,
                                          .read = driver_read,
                                          .write = driver_write,
                                          .truncate = driver_truncate,
                                          .fl_map = H5FD_FLMAP_DICHOTOMY};

herr_t pc_store_driver_use(pc_store_driver *driver, hid_t access_list) {
    driver->id = H5FDregister(&driver_class);
    if (driver->id < 0) return -1;
    return H5Pset_driver(access_list, driver->id, (const void *)&driver);
}

void pc_store_driver_release(pc_store_driver *driver) {
    if (driver->id >= 0) (void)H5FDunregister(driver->id);
    driver->id = H5I_INVALID_HID;
}
