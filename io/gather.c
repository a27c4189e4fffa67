#include "gather.h"
#include <stdio.h>

typedef struct gathering {
    pc_store *result, *stage;
} gathering;

static pc_status take_entry(void *user, const pc_store_entry *entry) {
    const gathering *g = user;
    if (entry->group) return pc_store_copy_attributes(g->result, entry->name, g->stage, entry->name);
    if (pc_store_has(g->result, entry->name))
        return pc_fail(pc_store_context(g->result), PC_E_BUG, "%s: '%s' comes from two stages",
                       pc_store_path(g->result), entry->name);
    return pc_store_copy(g->result, g->stage, entry->name);
}

pc_status pc_gather_stage(pc_store *result, pc_store *stage, const char *title) {
    char name[128];
    pc_status status = PC_OK;
    gathering g = {result, stage};
    (void)snprintf(name, sizeof name, "stages/%s", title);
    PC_TRY(pc_store_copy_attributes(result, name, stage, "/"));
    PC_TRY(pc_store_visit(stage, take_entry, &g));
done:
    return status;
}
