/* Text files written piece by piece: the first failure stays and makes all later puts idle, so that writers
 * of formats need no check per number. Numbers are the same in every locale. */
#ifndef PC_TEXTOUT_H
#define PC_TEXTOUT_H

#include "decimal.h"
#include "file.h"

typedef struct pc_textout {
    pc_writer writer;
    pc_status status;
} pc_textout;

/* PC_E_IO as pc_writer_open. */
pc_status pc_textout_open(pc_textout *out, pc_context *ctx, const char *path, bool force);
/* At most 511 characters, none of them from a double. */
void pc_textout_put(pc_textout *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same without a format: much faster for what there is a million of. */
void pc_textout_text(pc_textout *out, const char *text, size_t length);
void pc_textout_integer(pc_textout *out, uint64_t value);
/* The shortest decimals that read back the same, a space between each two. */
void pc_textout_reals(pc_textout *out, const double *x, size_t count);
/* Puts the file in place where `status` and all puts are PC_OK, else removes it. Returns the first failure.
 * Fine on a zeroed pc_textout with a failure. */
pc_status pc_textout_close(pc_textout *out, pc_status status);

#endif
