#include "columns.h"
#include "memory.h"
#include <stdio.h>
#include <string.h>

enum { NAME_BYTES = 200 };

static const char *full_name(char text[NAME_BYTES], const char *group, const char *name) {
    (void)snprintf(text, NAME_BYTES, "%s/%s", group, name);
    return text;
}

pc_status pc_columns_save(pc_store *store, const char *group, const pc_column *columns, size_t column_count,
                          const void *product, const size_t *counts) {
    char name[NAME_BYTES];
    for (size_t i = 0; i < column_count; i++) {
        const pc_column *c = &columns[i];
        const void *data;
        memcpy((void *)&data, (const char *)product + c->pointer, sizeof data);
        if (!data && c->optional) continue;
        size_t dims[2] = {counts[c->rows], (size_t)c->width};
        pc_status status = pc_store_put(store, full_name(name, group, c->name), c->type, c->width ? 2 : 1,
                                        dims, data, c->units, c->description);
        if (status != PC_OK) return status;
    }
    return PC_OK;
}

pc_status pc_columns_load(void *product, size_t *counts, pc_store *store, const char *group,
                          const pc_column *columns, size_t column_count) {
    char name[NAME_BYTES];
    for (size_t i = 0; i < column_count; i++) {
        const pc_column *c = &columns[i];
        void *data = NULL;
        size_t dims[2] = {counts[c->rows], (size_t)c->width};
        (void)full_name(name, group, c->name);
        if (c->optional && !pc_store_has(store, name)) continue;
        pc_status status = pc_store_get(&data, store, name, c->type, c->width ? 2 : 1, dims);
        if (status != PC_OK) return status;
        memcpy((char *)product + c->pointer, (void *)&data, sizeof data);
        counts[c->rows] = dims[0];
        if (dims[0] >= PC_NONE)
            return pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s': more rows than 32 bits can count",
                           pc_store_path(store), name);
    }
    return PC_OK;
}

static pc_status wrong_value(pc_store *store, const char *group, const char *name, size_t at,
                             unsigned long long value) {
    return pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s/%s': %llu in row %zu makes no sense",
                   pc_store_path(store), group, name, value, at);
}

pc_status pc_columns_below(pc_store *store, const char *group, const char *name, const pc_index *array,
                           size_t count, size_t limit, bool none_allowed) {
    for (size_t i = 0; i < count; i++)
        if (array[i] >= limit && !(none_allowed && array[i] == PC_NONE))
            return wrong_value(store, group, name, i, array[i]);
    return PC_OK;
}

pc_status pc_columns_bytes_below(pc_store *store, const char *group, const char *name, const uint8_t *array,
                                 size_t count, unsigned limit) {
    for (size_t i = 0; i < count; i++)
        if (array[i] >= limit) return wrong_value(store, group, name, i, array[i]);
    return PC_OK;
}

pc_status pc_columns_offsets(pc_store *store, const char *group, const char *name, const pc_index *offsets,
                             size_t count, size_t total) {
    if (count == 0)
        return pc_fail(pc_store_context(store), PC_E_FORMAT, "%s: '%s/%s': empty", pc_store_path(store),
                       group, name);
    if (offsets[0] != 0) return wrong_value(store, group, name, 0, offsets[0]);
    for (size_t i = 1; i < count; i++)
        if (offsets[i] < offsets[i - 1]) return wrong_value(store, group, name, i, offsets[i]);
    if (offsets[count - 1] != total) return wrong_value(store, group, name, count - 1, offsets[count - 1]);
    return PC_OK;
}
