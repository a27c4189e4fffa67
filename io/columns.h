/* The arrays of a product as a table: one description serves writing, reading and checking of sizes. */
#ifndef PC_COLUMNS_H
#define PC_COLUMNS_H

#include "store.h"

enum { PC_COLUMN_COUNTS = 8 };

typedef struct pc_column {
    const char *name; /* of the dataset in the product's group */
    pc_store_type type;
    int width;      /* numbers per row; 0 for a plain list */
    size_t rows;    /* which of the product's counts gives the number of rows */
    size_t pointer; /* offset of the array's pointer in the product */
    bool optional;  /* NULL where the dataset is missing */
    const char *units, *description;
} pc_column;

/* Writes the arrays of `product` into `group`. */
pc_status pc_columns_save(pc_store *store, const char *group, const pc_column *columns, size_t column_count,
                          const void *product, const size_t *counts);
/* Reads them; a count that is PC_STORE_ANY takes its value from the first array that has it, and the others
 * must agree. On failure the arrays read so far stay in the product, which its owner frees. PC_E_FORMAT,
 * PC_E_NOMEM. */
pc_status pc_columns_load(void *product, size_t *counts, pc_store *store, const char *group,
                          const pc_column *columns, size_t column_count);

/* For what arrays say about each other; all give PC_E_FORMAT with file, dataset and place. */
pc_status pc_columns_below(pc_store *store, const char *group, const char *name, const pc_index *array,
                           size_t count, size_t limit, bool none_allowed);
/* Offsets that begin with 0, never fall and end with `total`. */
pc_status pc_columns_offsets(pc_store *store, const char *group, const char *name, const pc_index *offsets,
                             size_t count, size_t total);
pc_status pc_columns_bytes_below(pc_store *store, const char *group, const char *name, const uint8_t *array,
                                 size_t count, unsigned limit);

#endif
