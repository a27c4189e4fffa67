/* How the HDF5 library writes our files: through a driver that never tells it of a failed write.
 *
 * HDF5 1.10 cannot give up a file whose writes fail (a full disk): closing fails too, the file stays open
 * inside the library, and the program crashes when it exits. This driver keeps the first error for us and
 * drops what follows; the store asks for the error after each array and before the file gets its name. */
#ifndef PC_STORE_DRIVER_H
#define PC_STORE_DRIVER_H

#include <hdf5.h>

typedef struct pc_store_driver {
    hid_t id;
    int file;  /* open for reading and writing, empty; the caller closes it after the HDF5 file */
    int error; /* errno of the first failure, 0 so far */
} pc_store_driver;

/* Makes a file access list use the driver; `driver` must outlive the HDF5 file. Negative on failure. */
herr_t pc_store_driver_use(pc_store_driver *driver, hid_t access_list);
/* To be called once the HDF5 file is closed. */
void pc_store_driver_release(pc_store_driver *driver);

#endif
