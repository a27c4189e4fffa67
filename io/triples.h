/* Text with three numbers per line: points, places on a surface. */
#ifndef PC_TRIPLES_H
#define PC_TRIPLES_H

#include "context.h"

typedef struct pc_triples {
    size_t count;
    double *value; /* 3 per row */
    size_t *line;  /* of the file, counted from 1 */
} pc_triples;

/* Numbers are parted by blanks or a comma; empty lines and what follows # are passed over, and so is a first
 * line of names (its first character is a letter). `path` "-" is standard input; `what` is how messages call
 * the three, such as "x y z". PC_E_FORMAT with "FILE:LINE:", PC_E_IO, PC_E_NOMEM. */
pc_status pc_triples_read(pc_triples *triples, pc_context *ctx, const char *path, const char *what);
void pc_triples_free(pc_triples *triples, pc_context *ctx);

#endif
