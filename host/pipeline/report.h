/* The report of a conversion: what went in, what was done, how good the result is. */
#ifndef PC_REPORT_H
#define PC_REPORT_H

#include "certificate.h"
#include "distortion.h"
#include "spline_files.h"
#include "stage.h"

/* What is known of the result; parts that were not reached are absent. */
typedef struct pc_findings {
    bool has_distortion, has_quality, has_spline;
    pc_distortion distortion;
    pc_quality quality;
    pc_certificate certificate;
    pc_spline_findings spline;
} pc_findings;

/* The figures without times: the same for the same result. Compact where they go into a file as one text. */
void pc_report_put_statistics(pc_json *json, const char *key, const pc_findings *findings);
void pc_report_put_certificate(pc_json *json, const char *key, const pc_certificate *certificate);
/* All of report.json. */
pc_status pc_report_make(pc_json *json, const pc_run *run, const pc_findings *findings);

#endif
