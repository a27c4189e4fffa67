#include "command.h"
#include "json.h"
#include "memory.h"
#include "store.h"
#include <string.h>

static const char usage[] = "info FILE.h5 [--json]";
static const char about[] =
    "Tells what an HDF5 file of Percale holds: where it comes from, its arrays, their sizes and "
    "units.";

/* Root attributes of stage files and results; those that are missing are passed over. */
static const char *const texts[] = {"program", "stage",   "input", "input_sha256",
                                    "device",  "options", "note",  "key"};
enum { TEXT_COUNT = sizeof texts / sizeof *texts };

typedef struct listing {
    pc_json json;
    bool as_json;
} listing;

static pc_status put_texts(listing *list, pc_context *ctx, pc_store *store) {
    pc_status status = PC_OK;
    for (int i = 0; i < TEXT_COUNT; i++) {
        char *value = NULL;
        status = pc_store_get_text(&value, store, "/", texts[i]);
        if (status == PC_E_FORMAT) {
            pc_context_clear_message(ctx);
            continue;
        }
        if (status != PC_OK) return status;
        bool is_json = value[0] == '{';
        if (!list->as_json)
            (void)printf("%-13s %s\n", texts[i], value);
        else if (is_json)
            pc_json_raw(&list->json, texts[i], value);
        else
            pc_json_string(&list->json, texts[i], value);
        pc_free(ctx, value);
    }
    return PC_OK;
}

static pc_status put_entry(void *user, const pc_store_entry *entry) {
    listing *list = user;
    if (entry->group) return PC_OK;
    if (list->as_json) {
        pc_json_object(&list->json, NULL);
        pc_json_string(&list->json, "name", entry->name);
        pc_json_string(&list->json, "type", entry->type);
        pc_json_flat_array(&list->json, "shape");
        for (int k = 0; k < entry->rank; k++)
            pc_json_integer(&list->json, NULL, (int64_t)entry->dims[k]);
        pc_json_close(&list->json);
        pc_json_integer(&list->json, "stored_bytes", (int64_t)entry->stored_bytes);
        pc_json_string(&list->json, "units", entry->units);
        pc_json_string(&list->json, "description", entry->description);
        pc_json_close(&list->json);
        return PC_OK;
    }
    char shape[96] = "";
    for (int k = 0; k < entry->rank; k++) {
        size_t length = strlen(shape);
        (void)snprintf(shape + length, sizeof shape - length, "%s%zu", k ? " x " : "", entry->dims[k]);
    }
    (void)printf("%-28s %-8s %-14s %-8s %s\n", entry->name, entry->type, shape, entry->units,
                 entry->description);
    return PC_OK;
}

static pc_status print_file(listing *list, pc_context *ctx, const char *path) {
    pc_store *store = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_store_open(&store, ctx, path));
    if (list->as_json) {
        pc_json_object(&list->json, NULL);
        pc_json_string(&list->json, "file", path);
    }
    PC_TRY(put_texts(list, ctx, store));
    if (list->as_json)
        pc_json_array(&list->json, "datasets");
    else
        (void)printf("\n");
    PC_TRY(pc_store_visit(store, put_entry, list));
    if (list->as_json) {
        pc_json_close(&list->json);
        pc_json_close(&list->json);
        PC_TRY(pc_json_end(&list->json));
        (void)fputs(list->json.text, stdout);
    }
done:
    pc_store_close(store);
    return status;
}

pc_status pc_command_info(pc_context *ctx, int argc, const char **argv) {
    listing list = {.as_json = false};
    pc_option table[] = {PC_FLAG("json", 0, &list.as_json, "print JSON"), PC_OPTIONS_END};
    pc_operands operands;
    pc_status status = PC_OK;
    pc_json_start(&list.json, ctx, false);
    PC_TRY(pc_options_read(&operands, ctx, table, argc, argv));
    if (operands.help_asked) {
        pc_command_help(usage, about, table);
        goto done;
    }
    PC_TRY(pc_command_operands(ctx, &operands, 1, usage));
    PC_TRY(print_file(&list, ctx, operands.text[0]));
done:
    pc_json_free(&list.json);
    return status;
}
