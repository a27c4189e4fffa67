/* Unpacks gzip in memory. */
#ifndef PC_GUNZIP_H
#define PC_GUNZIP_H

#include "context.h"

bool pc_gunzip_is(const char *data, size_t size);

/* All members of a gzip file, one behind the other; `name` is for messages, `*out` the caller's (pc_free).
 * Memory grows with what really comes out, whatever the file says of its size. PC_E_FORMAT where the file is
 * damaged or truncated. */
pc_status pc_gunzip(char **out, size_t *out_size, pc_context *ctx, const char *name, const char *data,
                    size_t size);

#endif
