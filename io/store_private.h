/* What store.c, store_attribute.c and store_read.c share. */
#ifndef PC_STORE_PRIVATE_H
#define PC_STORE_PRIVATE_H

#include "store.h"
#include "store_driver.h"
#include <hdf5.h>

struct pc_store {
    pc_context *ctx;
    char *path;
    char *partial;  /* NULL in a store that is read */
    uint64_t bytes; /* length of a file that is read */
    hid_t file;
    hid_t group_list;
    pc_store_driver driver; /* of a store that is written */
    bool compress;
};

/* "path: 'name': what", and what the HDF5 library says. */
pc_status pc_store_fail(pc_store *store, pc_status status, const char *name, const char *what);
/* PC_E_IO with the system's words where something written did not arrive. */
pc_status pc_store_check_written(pc_store *store);
/* The group `name` and those above it, opened or made. "" and "/" are the root. */
pc_status pc_store_group(hid_t *group, pc_store *store, const char *name);
/* Any existing object; in a store that is written a missing one becomes a group. */
pc_status pc_store_object(hid_t *object, pc_store *store, const char *name);
/* Types in the file (little endian) and in memory. */
hid_t pc_store_file_type(pc_store_type type);
hid_t pc_store_memory_type(pc_store_type type);
size_t pc_store_type_size(pc_store_type type);

#endif
