#include "html_parts.h"
#include <math.h>

void pc_html_row(pc_html *html, const char *name) {
    pc_html_put(html, "<tr><th>");
    pc_html_put(html, name);
    pc_html_put(html, "</th><td>");
}

void pc_html_row_end(pc_html *html) {
    pc_html_put(html, "</td></tr>\n");
}

static void put_count(pc_html *html, const char *name, double value) {
    pc_html_row(html, name);
    pc_html_count(html, value);
    pc_html_row_end(html);
}

static void put_number(pc_html *html, const char *name, double value) {
    pc_html_row(html, name);
    pc_html_number(html, value);
    pc_html_row_end(html);
}

/* A length, and what that is of the diagonal. */
static void put_length(pc_html *html, const char *name, double length, double diagonal) {
    pc_html_row(html, name);
    pc_html_number(html, length);
    pc_html_print(html, " <span class=\"soft\">(%.3g&#8201;%%)</span>", 100 * length / diagonal);
    pc_html_row_end(html);
}

static void put_figures(pc_html *html, const pc_findings *findings, const pc_album *album) {
    const pc_held_spline *held = findings->spline.held;
    const pc_accuracy *a = &held->stats.accuracy;
    pc_html_put(html, "<div class=\"pairs\"><table><caption>Size</caption><tbody>\n");
    put_count(html, "control points", held->surface.mesh.vertex_count);
    put_count(html, "T-junctions", held->stats.junctions);
    put_count(html, "bicubic patches (Bezier)", held->surface.basis.element_count);
    put_count(html, "faces in CAD files", findings->spline.shell.face_count);
    put_count(html, "border edges in CAD files", findings->spline.shell.border_count);
    put_count(html, "rounds of refinement", held->stats.rounds);
    put_number(html, "area, units of the scan squared", findings->spline.measure.area);
    if (findings->spline.measure.closed) put_number(html, "volume", findings->spline.measure.volume);
    pc_html_put(html, "</tbody></table>\n<table><caption>Distance <span class=\"soft\">(of the "
                      "diagonal)</span></caption><tbody>\n");
    put_length(html, "tolerance", held->tolerance, held->diagonal);
    put_length(html, "largest, both ways", a->max, held->diagonal);
    if (held->earlier_error > 0)
        put_length(html, "largest in the try that was not kept", held->earlier_error, held->diagonal);
    put_length(html, "scan to surface, largest", a->scan_max, held->diagonal);
    put_length(html, "scan to surface, mean", a->scan_mean, held->diagonal);
    put_length(html, "surface to scan, largest", a->surface_max, held->diagonal);
    put_length(html, "surface to scan, mean", a->surface_mean, held->diagonal);
    if (album->has_errors) {
        const double within = album->errors.within; /* all is all only where nothing is left */
        pc_html_row(html, "of the surface within the tolerance");
        pc_html_print(html, "%.4g&#8201;%%", within < 1 ? fmin(100 * within, 99.99) : 100);
        pc_html_row_end(html);
        put_length(html, "half of the surface is within", album->errors.quantile[0], held->diagonal);
        put_length(html, "95&#8201;% are within", album->errors.quantile[1], held->diagonal);
        put_length(html, "99&#8201;% are within", album->errors.quantile[2], held->diagonal);
    }
    pc_html_put(html, "</tbody></table></div>\n<p class=\"soft\">Measured at ");
    pc_html_count(html, (double)a->samples);
    pc_html_put(html, " points");
    if (a->beyond) {
        pc_html_put(html, "; ");
        pc_html_count(html, (double)a->beyond);
        pc_html_put(html, " more lie where the scan has no data, and do not count");
    }
    pc_html_put(html, ". Diagonal of the box around the scan: ");
    pc_html_number(html, held->diagonal);
    pc_html_put(html, ".</p>\n");
}

static void put_degrees(pc_html *html, double radians) {
    pc_html_put(html, "<td class=\"n\">");
    pc_html_print(html, radians > 1e-6 ? "%.3g&#176;" : "0&#176;", radians * 180 / PC_PI);
    pc_html_put(html, "</td>");
}

static void put_joint(pc_html *html, const char *name, const char *class_, const pc_jump *jump,
                      double diagonal) {
    pc_html_print(html, "<tr><th>%s</th><td>%s</td><td class=\"n\">", name, class_);
    pc_html_count(html, jump->sample_count);
    pc_html_print(html, "</td><td class=\"n\">%.1g</td>", jump->gap / diagonal);
    put_degrees(html, jump->normal_mean);
    put_degrees(html, jump->normal_max);
    pc_html_print(html, "<td class=\"n\">%.2g</td><td class=\"n\">%.2g</td></tr>\n", jump->curvature_mean,
                  jump->curvature_max);
}

static void put_continuity(pc_html *html, const pc_spline_findings *findings) {
    static const char *const name[PC_JOINT_COUNT] = {
        "between regular patches", "in faces with an extraordinary corner", "around closing patches",
        "edges that leave an extraordinary vertex"};
    static const char *const order[PC_JOINT_COUNT] = {"C2", "C2", "C1", "C0, nearly G1"};
    pc_html_put(
        html, "<h3>How smooth it is</h3>\n<p>Measured on both sides of every edge between patches. The gap "
              "is told as a part of the diagonal, the jump of the curvature across the edge times the "
              "size of the patch.</p>\n<div class=\"wide\"><table><thead><tr><th rowspan=\"2\">edges</th><th "
              "rowspan=\"2\">built as</th><th class=\"n\" rowspan=\"2\">samples</th><th class=\"n\" "
              "rowspan=\"2\">gap</th><th class=\"n\" colspan=\"2\">normals</th><th class=\"n\" "
              "colspan=\"2\">curvature</th></tr><tr><th class=\"n\">mean</th><th class=\"n\">most</th><th "
              "class=\"n\">mean</th><th class=\"n\">most</th></tr></thead><tbody>\n");
    for (int c = 0; c < PC_JOINT_COUNT; c++)
        if (findings->jump[c].sample_count)
            put_joint(html, name[c], order[c], findings->jump + c, findings->held->diagonal);
    pc_html_put(html, "</tbody></table></div>\n");
}

void pc_html_spline(pc_html *html, const pc_findings *findings, const pc_album *album) {
    pc_html_put(html, "<h2>The spline surface</h2>\n");
    put_figures(html, findings, album);
    pc_html_figure(html, album, PC_PREVIEW_ERROR);
    if (album->has_errors) pc_html_histogram(html, &album->errors, findings->spline.held->tolerance);
    pc_html_figure(html, album, PC_PREVIEW_ZEBRA);
    pc_html_figure(html, album, PC_PREVIEW_SURFACE);
    put_continuity(html, &findings->spline);
}
