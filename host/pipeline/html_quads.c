#include "html_parts.h"

static void put_counts(pc_html *html, const char *name, double scan, double quads) {
    pc_html_print(html, "<tr><th>%s</th><td>", name);
    pc_html_count(html, scan);
    pc_html_put(html, "</td><td>");
    pc_html_count(html, quads);
    pc_html_put(html, "</td></tr>\n");
}

static void put_topology(pc_html *html, const pc_quality *q) {
    pc_html_put(html, "<table><caption>Topology</caption><thead><tr><th></th><th class=\"n\">scan</th><th "
                      "class=\"n\">quads</th></tr></thead><tbody>\n");
    put_counts(html, "vertices", q->scan.vertices, q->quads.vertices);
    put_counts(html, "faces", q->scan.faces, q->quads.faces);
    put_counts(html, "pieces", q->scan.components, q->quads.components);
    put_counts(html, "Euler number", (double)q->scan.chi, (double)q->quads.chi);
    put_counts(html, "border loops", q->scan.loops, q->quads.loops);
    pc_html_put(html, "</tbody></table>\n");
}

static void put_number(pc_html *html, const char *name, double value, const char *unit) {
    pc_html_row(html, name);
    pc_html_number(html, value);
    pc_html_put(html, unit);
    pc_html_row_end(html);
}

static void put_spread(pc_html *html, const char *name, const pc_spread *spread, const char *unit) {
    const double value[4] = {spread->mean, spread->q05, spread->q95, spread->max};
    pc_html_print(html, "<tr><th>%s</th>", name);
    for (int k = 0; k < 4; k++) {
        pc_html_put(html, "<td>");
        pc_html_number(html, value[k]);
        pc_html_put(html, unit);
        pc_html_put(html, "</td>");
    }
    pc_html_put(html, "</tr>\n");
}

static void put_deviation(pc_html *html, const char *name, const pc_deviation *d) {
    const double value[3] = {d->mean, d->q95, d->max};
    pc_html_print(html, "<tr><th>%s</th>", name);
    for (int k = 0; k < 3; k++) {
        pc_html_put(html, "<td>");
        pc_html_number(html, value[k]);
        pc_html_put(html, "</td>");
    }
    pc_html_put(html, "</tr>\n");
}

void pc_html_quads(pc_html *html, const pc_findings *findings) {
    const pc_quality *q = &findings->quality;
    pc_html_put(html, "<h2>The quads</h2>\n<div class=\"pairs\">");
    put_topology(html, q);
    pc_html_put(html, "<table><caption>Regularity</caption><tbody>\n");
    put_number(html, "cells with four sides", q->quad_cell_percent, "&#8201;%");
    pc_html_row(html, "irregular vertices inside");
    pc_html_count(html, q->irregular_interior);
    pc_html_row_end(html);
    pc_html_row(html, "irregular vertices on borders");
    pc_html_count(html, q->irregular_boundary);
    pc_html_row_end(html);
    pc_html_row(html, "T-junctions");
    pc_html_count(html, q->t_junctions);
    pc_html_row_end(html);
    pc_html_row(html, "folded cells");
    pc_html_count(html, q->shape.folded_cells);
    pc_html_row_end(html);
    if (findings->has_distortion) {
        put_number(html, "stretch of the parameters (1 is best)", findings->distortion.stretch_core, "");
        put_number(html, "shear of the parameters (0 is best)", findings->distortion.shear, "");
    }
    pc_html_put(html, "</tbody></table>\n<table><caption>Shape</caption><thead><tr><th></th><th class=\"n\">"
                      "mean</th><th class=\"n\">5&#8201;%</th><th class=\"n\">95&#8201;%</th><th class=\"n\">"
                      "most</th></tr></thead><tbody>\n");
    put_spread(html, "edge length", &q->shape.edge_length, "");
    put_spread(html, "off the right angle", &q->shape.angle, "&#176;");
    put_spread(html, "length to width", &q->shape.aspect, "");
    put_spread(html, "warp", &q->shape.warp, "&#176;");
    put_spread(html, "off the directions", &q->field_angle, "&#176;");
    pc_html_put(html,
                "</tbody></table>\n<table><caption>Distance, units of the scan</caption><thead><tr><th></th>"
                "<th class=\"n\">mean</th><th class=\"n\">95&#8201;%</th><th class=\"n\">most</th></tr>"
                "</thead><tbody>\n");
    put_deviation(html, "scan to quads", &q->scan_to_quads);
    put_deviation(html, "quads to scan", &q->quads_to_scan);
    pc_html_put(html, "</tbody></table></div>\n<p class=\"soft\">Of the diagonal ");
    pc_html_number(html, q->diagonal);
    pc_html_print(html, ", the largest distances are %.3g&#8201;%% and %.3g&#8201;%%.</p>\n",
                  100 * q->scan_to_quads.max / q->diagonal, 100 * q->quads_to_scan.max / q->diagonal);
}
