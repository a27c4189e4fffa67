/* report.html: what a person looks at to take a result or leave it, on one page that needs nothing beside
 * itself: no network, no scripts; pictures inside. */
#ifndef PC_HTML_REPORT_H
#define PC_HTML_REPORT_H

#include "html_text.h"
#include "previews.h"
#include "report.h"

/* The page of a run whose findings and pictures (those that there are) are made; nothing is measured here.
 * What differs between two runs of the same conversion (times, memory, threads) stands in elements of class
 * "time" without others inside; all else is the same bytes. PC_E_NOMEM. */
pc_status pc_html_report_make(pc_html *html, const pc_run *run, const pc_findings *findings,
                              const pc_album *album);
/* Writes it into the folder of the run. PC_E_IO. */
pc_status pc_html_report_write(const pc_run *run, const pc_findings *findings, const pc_album *album);

#endif
