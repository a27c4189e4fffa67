/* The header of a PLY file: which elements and properties follow, and how they are written. */
#ifndef PC_PLY_HEADER_H
#define PC_PLY_HEADER_H

#include "scan_input.h"

typedef enum pc_ply_type {
    PC_PLY_INT8,
    PC_PLY_UINT8,
    PC_PLY_INT16,
    PC_PLY_UINT16,
    PC_PLY_INT32,
    PC_PLY_UINT32,
    PC_PLY_INT64,
    PC_PLY_UINT64,
    PC_PLY_FLOAT32,
    PC_PLY_FLOAT64,
    PC_PLY_TYPES
} pc_ply_type;

typedef enum pc_ply_format { PC_PLY_ASCII, PC_PLY_LITTLE, PC_PLY_BIG } pc_ply_format;

/* A word of the file itself, not 0-terminated. */
typedef struct pc_ply_name {
    const char *at;
    const char *end;
} pc_ply_name;

typedef struct pc_ply_property {
    pc_ply_name name;
    pc_ply_type type;
    pc_ply_type count_type; /* of a list */
    bool is_list;
} pc_ply_property;

typedef struct pc_ply_element {
    pc_ply_name name;
    size_t count;
    int first; /* property */
    int property_count;
    size_t least_bytes; /* what one record takes at least: binary the sum of all but list items, ascii 2 per
                           value */
    bool has_list;
} pc_ply_element;

enum { PC_PLY_MAX_ELEMENTS = 32, PC_PLY_MAX_PROPERTIES = 512 };

typedef struct pc_ply_header {
    pc_ply_format format;
    int element_count;
    int property_count;
    pc_ply_element element[PC_PLY_MAX_ELEMENTS];
    pc_ply_property property[PC_PLY_MAX_PROPERTIES];
    size_t body; /* offset of the first byte behind the header */
} pc_ply_header;

/* PC_E_FORMAT with the line, also where the rest of the file cannot hold what the header promises. */
pc_status pc_ply_header_read(pc_ply_header *header, pc_context *ctx, const pc_scan_input *input);

size_t pc_ply_type_size(pc_ply_type type);
bool pc_ply_name_is(pc_ply_name name, const char *word);
/* The property of an element by name, -1 where there is none. */
int pc_ply_find(const pc_ply_header *header, const pc_ply_element *element, const char *name);

#endif
