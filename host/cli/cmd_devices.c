#include "command.h"
#include "device.h"
#include "json.h"
#include "memory.h"

static const char usage[] = "devices [--json]";
static const char about[] = "Lists the OpenCL devices; their first column is what --device takes.";

static void print_json(pc_json *json, const pc_device_info *info, size_t count) {
    pc_json_object(json, NULL);
    pc_json_array(json, "devices");
    for (size_t i = 0; i < count; i++, info++) {
        pc_json_object(json, NULL);
        pc_json_integer(json, "platform", info->platform);
        pc_json_integer(json, "device", info->device);
        pc_json_string(json, "name", info->name);
        pc_json_string(json, "platform_name", info->platform_name);
        pc_json_string(json, "version", info->version);
        pc_json_string(json, "driver", info->driver);
        pc_json_string(json, "type", info->gpu ? "gpu" : info->cpu ? "cpu" : "other");
        pc_json_boolean(json, "doubles", info->doubles);
        pc_json_integer(json, "units", info->units);
        pc_json_integer(json, "memory_bytes", (int64_t)info->memory_bytes);
        pc_json_integer(json, "allocation_cap_bytes", (int64_t)info->allocation_cap);
        pc_json_close(json);
    }
    pc_json_close(json);
    pc_json_close(json);
}

static void print_table(const pc_device_info *info, size_t count) {
    for (size_t i = 0; i < count; i++, info++)
        (void)printf("%d:%d   %-3s  %s\n           %s, %s, driver %s\n           %u units, %.1f GB, buffers "
                     "up to %.1f "
                     "GB, %s\n",
                     info->platform, info->device,
                     info->gpu   ? "gpu"
                     : info->cpu ? "cpu"
                                 : "-",
                     info->name, info->platform_name, info->version, info->driver, info->units,
                     1e-9 * (double)info->memory_bytes, 1e-9 * (double)info->allocation_cap,
                     info->doubles ? "double precision" : "no double precision");
    if (count == 0) (void)printf("no OpenCL device; pocl-opencl-icd is one for any CPU\n");
    (void)printf("host  cpu  plain C with OpenMP, no OpenCL\n");
}

pc_status pc_command_devices(pc_context *ctx, int argc, const char **argv) {
    bool json_wanted = false;
    pc_option table[] = {PC_FLAG("json", 0, &json_wanted, "print JSON"), PC_OPTIONS_END};
    pc_operands operands;
    pc_device_info *infos = NULL;
    size_t count = 0;
    pc_json json;
    pc_status status = PC_OK;
    pc_json_start(&json, ctx, false);
    PC_TRY(pc_options_read(&operands, ctx, table, argc, argv));
    if (operands.help_asked) {
        pc_command_help(usage, about, table);
        goto done;
    }
    PC_TRY(pc_command_operands(ctx, &operands, 0, usage));
    PC_TRY(pc_device_list(&infos, &count, ctx));
    if (!json_wanted) {
        print_table(infos, count);
        goto done;
    }
    print_json(&json, infos, count);
    PC_TRY(pc_json_end(&json));
    (void)fputs(json.text, stdout);
done:
    pc_json_free(&json);
    pc_free(ctx, infos);
    return status;
}
