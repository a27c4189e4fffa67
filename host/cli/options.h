/* Reads command lines from a table of options, and prints the help from the same table. */
#ifndef PC_OPTIONS_H
#define PC_OPTIONS_H

#include "context.h"
#include <stdio.h>

typedef enum pc_option_kind {
    PC_OPTION_FLAG,   /* bool */
    PC_OPTION_TEXT,   /* const char * */
    PC_OPTION_COUNT,  /* uint64_t; 20k and 1.5M are understood */
    PC_OPTION_NUMBER, /* double */
    PC_OPTION_CHOICE, /* int: place in `choices`, words parted by | */
    PC_OPTION_SIZE    /* two uint32_t: 800x600 */
} pc_option_kind;

typedef struct pc_option {
    const char *name; /* without the dashes; NULL ends a table */
    void *value;
    const char *argument; /* how the help calls it */
    const char *help;
    const char *choices;
    double least, most; /* of numbers and counts, both allowed; 0,0: no limits */
    pc_option_kind kind;
    char letter; /* 0 where there is no short form */
    bool given;  /* set by pc_options_read */
} pc_option;

/* Rows of a table. */
#define PC_FLAG(n, l, v, h)                                                                                  \
    { .name = (n), .letter = (l), .kind = PC_OPTION_FLAG, .value = (v), .help = (h) }
#define PC_TEXT(n, l, v, a, h)                                                                               \
    { .name = (n), .letter = (l), .kind = PC_OPTION_TEXT, .value = (v), .argument = (a), .help = (h) }
#define PC_COUNT(n, v, a, low, high, h)                                                                      \
    {                                                                                                        \
        .name = (n), .kind = PC_OPTION_COUNT, .value = (v), .argument = (a), .help = (h), .least = (low),    \
        .most = (high)                                                                                       \
    }
#define PC_NUMBER(n, v, a, low, high, h)                                                                     \
    {                                                                                                        \
        .name = (n), .kind = PC_OPTION_NUMBER, .value = (v), .argument = (a), .help = (h), .least = (low),   \
        .most = (high)                                                                                       \
    }
#define PC_CHOICE(n, v, words, h)                                                                            \
    {                                                                                                        \
        .name = (n), .kind = PC_OPTION_CHOICE, .value = (v), .argument = (words), .help = (h),               \
        .choices = (words)                                                                                   \
    }
#define PC_SIZE(n, v, h)                                                                                     \
    { .name = (n), .kind = PC_OPTION_SIZE, .value = (v), .argument = "WxH", .help = (h) }
#define PC_OPTIONS_END                                                                                       \
    { .name = NULL }

typedef struct pc_operands {
    const char **text; /* into argv */
    int count;
    bool help_asked; /* --help or -h stood there */
} pc_operands;

/* argv[0] is the command's name. Moves the operands to the front of argv. PC_E_USAGE names the option at
 * fault and the nearest that exists. */
pc_status pc_options_read(pc_operands *operands, pc_context *ctx, pc_option *table, int argc,
                          const char **argv);

/* One line per option. */
void pc_options_print(FILE *out, const pc_option *table);

/* The word of `words` (NULL at its end) nearest to `typed`; NULL where none is near. */
const char *pc_nearest_word(const char *typed, const char *const *words);

#endif
