/* A block system in a file of its own, so that each solver of a comparison runs in a process of its own. */
#ifndef PC_SYSTEM_FILE_H
#define PC_SYSTEM_FILE_H

#include "system.h"

/* Little-endian: u32 kind, rows, entries, 0; u32 start[rows + 1], column[entries]; f64 diagonal[rows],
 * value[width * entries]; u8 turn[entries] for TURNED. */
pc_status pc_system_save(const pc_system *system, pc_context *ctx, const char *path);
pc_status pc_system_load(pc_system *system, pc_context *ctx, const char *path);

#endif
