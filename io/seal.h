/* The seal of a store: a line of text after the HDF5 bytes that gives their length and checksum.
 *
 * HDF5 finds its own end in its superblock and does not look at what follows, so every reader still opens the
 * file. Percale hands a file to the HDF5 library only when the seal is right: the library may crash on
 * damaged metadata. */
#ifndef PC_SEAL_H
#define PC_SEAL_H

#include "context.h"

/* Appends the seal to the closed file `path` and flushes it to the disk. PC_E_IO. */
pc_status pc_seal_write(pc_context *ctx, const char *path);
/* PC_E_IO where the file cannot be read, PC_E_FORMAT where it has no seal or another length or checksum.
 * `bytes` gets the length of the HDF5 part. */
pc_status pc_seal_check(uint64_t *bytes, pc_context *ctx, const char *path);
/* Renames and makes the new name last through a power cut. PC_E_IO. */
pc_status pc_seal_publish(pc_context *ctx, const char *temporary, const char *path);

#endif
