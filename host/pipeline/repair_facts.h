/* What a scan's file held and what repair did to it, as JSON. */
#ifndef PC_REPAIR_FACTS_H
#define PC_REPAIR_FACTS_H

#include "json.h"
#include "repair.h"
#include "scan.h"

/* Adds the members of an open object: format, counts. */
void pc_facts_put_file(pc_json *json, const pc_scan_info *info);
/* Adds one object per defect: its count and the first few places; defects that did not occur have count 0. */
void pc_facts_put_repair(pc_json *json, const char *key, const pc_repair_report *report);
/* One line, such as "3 duplicate faces dropped, 2 bow-ties split"; "" where nothing was done. */
void pc_facts_repair_line(char *line, size_t size, const pc_repair_report *report);

#endif
