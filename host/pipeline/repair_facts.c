#include "repair_facts.h"
#include <stdio.h>
#include <string.h>

typedef struct defect_name {
    size_t offset; /* of the pc_defect in the report */
    const char *key;
    const char *words; /* after a number */
    const char *ids;   /* what its ids count */
} defect_name;

#define AT(member) offsetof(pc_repair_report, member)

static const defect_name defects[] = {
    {AT(merged_vertices), "merged_vertices", "coincident vertices merged", "vertex"},
    {AT(isolated_vertices), "isolated_vertices", "isolated vertices dropped", "vertex"},
    {AT(degenerate_faces), "degenerate_faces", "degenerate faces dropped", "face"},
    {AT(duplicate_faces), "duplicate_faces", "duplicate faces dropped", "face"},
    {AT(crowded_edges), "crowded_edges", "edges with more than two faces cut", "half-edge"},
    {AT(torn_edges), "torn_edges", "edges torn in pieces without orientation", "half-edge"},
    {AT(flipped_faces), "flipped_faces", "faces turned round", "face"},
    {AT(split_vertices), "split_vertices", "bow-tie vertices split", "vertex"},
    {AT(cut_vertices), "cut_vertices", "vertices split along cut edges", "vertex"},
    {AT(cut_edges), "cut_edges", "double edges halved", "half-edge"},
    {AT(dropped_components), "dropped_components", "small components dropped", "face"},
    {AT(dropped_faces), "dropped_faces", "faces of small components dropped", "face"},
    {AT(zero_area_faces), "zero_area_faces", "zero-area faces found", "face"},
};
enum { DEFECT_COUNT = sizeof defects / sizeof *defects };

static const pc_defect *defect_of(const pc_repair_report *report, const defect_name *name) {
    return (const pc_defect *)(const void *)((const char *)report + name->offset);
}

void pc_facts_put_file(pc_json *json, const pc_scan_info *info) {
    pc_json_string(json, "format", info->format);
    pc_json_boolean(json, "gzip", info->gzip);
    pc_json_integer(json, "file_bytes", (int64_t)info->file_bytes);
    pc_json_integer(json, "vertices", (int64_t)info->vertex_count);
    pc_json_integer(json, "faces", (int64_t)info->face_count);
    pc_json_integer(json, "polygons", (int64_t)info->polygon_count);
    pc_json_integer(json, "strips", (int64_t)info->strip_count);
    pc_json_integer(json, "short_faces", (int64_t)info->short_face_count);
    pc_json_integer(json, "welded_corners", (int64_t)info->welded_count);
    pc_json_string(json, "ignored", info->ignored);
}

void pc_facts_put_repair(pc_json *json, const char *key, const pc_repair_report *report) {
    pc_json_object(json, key);
    for (int i = 0; i < DEFECT_COUNT; i++) {
        const pc_defect *defect = defect_of(report, &defects[i]);
        pc_json_flat_object(json, defects[i].key);
        pc_json_integer(json, "count", defect->count);
        if (defect->count) {
            pc_json_string(json, "ids_of", defects[i].ids);
            pc_json_flat_array(json, "first");
            for (pc_index k = 0; k < defect->count && k < PC_DEFECT_IDS; k++)
                pc_json_integer(json, NULL, defect->id[k]);
            pc_json_close(json);
        }
        pc_json_close(json);
    }
    pc_json_integer(json, "cured_zero_area", report->cured_zero_area);
    pc_json_integer(json, "vertices", report->vertex_count);
    pc_json_integer(json, "faces", report->face_count);
    pc_json_boolean(json, "changed", report->changed);
    pc_json_close(json);
}

void pc_facts_repair_line(char *line, size_t size, const pc_repair_report *report) {
    line[0] = '\0';
    for (int i = 0; i < DEFECT_COUNT; i++) {
        const pc_defect *defect = defect_of(report, &defects[i]);
        size_t used = strlen(line);
        if (defect->count && used + 1 < size)
            (void)snprintf(line + used, size - used, "%s%u %s", used ? ", " : "", defect->count,
                           defects[i].words);
    }
}
