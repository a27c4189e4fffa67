/* The parts that report.html is put together from. */
#ifndef PC_HTML_PARTS_H
#define PC_HTML_PARTS_H

#include "html_text.h"
#include "previews.h"
#include "report.h"

/* The style sheet: light and dark, screen and paper. */
extern const char *const pc_html_style;

/* A picture of the album with a line under it; nothing where the album has none. */
void pc_html_figure(pc_html *html, const pc_album *album, pc_preview_kind kind);
/* A row of a table of names and values: the name, then what the caller puts, then pc_html_row_end. */
void pc_html_row(pc_html *html, const char *name);
void pc_html_row_end(pc_html *html);

/* The spline: figures, pictures, histogram, how smooth it is. */
void pc_html_spline(pc_html *html, const pc_findings *findings, const pc_album *album);
/* Distances as a drawing: bars for the surface, a line for the vertices of the scan, the tolerance. */
void pc_html_histogram(pc_html *html, const pc_errors *errors, double tolerance);
/* The first thing to read: whether this is what was asked for, and what one does where it is not. */
void pc_html_verdict(pc_html *html, const pc_run *run, const pc_findings *findings);
/* All checks with their figures. */
void pc_html_certificate(pc_html *html, const pc_certificate *certificate);
/* The quads' figures. */
void pc_html_quads(pc_html *html, const pc_findings *findings);

#endif
