/* The commands of the program. Each reads its own options; argv[0] is its name. */
#ifndef PC_COMMAND_H
#define PC_COMMAND_H

#include "options.h"

typedef pc_status pc_command(pc_context *ctx, int argc, const char **argv);

pc_command pc_command_convert, pc_command_check, pc_command_info, pc_command_render, pc_command_eval,
    pc_command_devices;

/* Usage, one paragraph, the options of `table`, to stdout. */
void pc_command_help(const char *usage, const char *text, const pc_option *table);

/* Exactly `count` operands, or PC_E_USAGE with the command's usage. */
pc_status pc_command_operands(pc_context *ctx, const pc_operands *operands, int count, const char *usage);

#endif
