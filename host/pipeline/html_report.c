#include "html_report.h"
#include "file.h"
#include "folder.h"
#include "html_parts.h"
#include "memory.h"
#include "version.h"
#include <omp.h>
#include <string.h>

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

void pc_html_figure(pc_html *html, const pc_album *album, pc_preview_kind kind) {
    static const char *const caption[PC_PREVIEW_COUNT] = {
        [PC_PREVIEW_SCAN] = "<b>The scan</b>, repaired, as it was converted.",
        [PC_PREVIEW_CURVATURE] = "<b>Mean curvature.</b> Red bulges outward, blue inward.",
        [PC_PREVIEW_FIELD] = "<b>Directions</b> that the quads follow, and their singularities.",
        [PC_PREVIEW_ISOLINES] = "<b>Parameters:</b> lines of whole and half periods.",
        [PC_PREVIEW_LAYOUT] = "<b>Cells</b> that the lines cut the scan into.",
        [PC_PREVIEW_QUADS] =
            "<b>The quads.</b> Balls: irregular vertices, red of valence 3, blue of 5, violet of "
            "more, orange of less.",
        [PC_PREVIEW_SURFACE] = "<b>Patches:</b> the lines of the control mesh on the surface. Balls: "
                               "extraordinary vertices, red of valence 3, blue of 5, violet of others; small "
                               "orange ones: T-junctions.",
        [PC_PREVIEW_ZEBRA] =
            "<b>Reflection lines:</b> stripes of light as the surface mirrors them. They flow "
            "where it is smooth; a kink of a stripe is a jump of the curvature, a break is a "
            "crease.",
        [PC_PREVIEW_ERROR] =
            "<b>Distance to the scan</b>, in its units. Red is beyond the tolerance; grey is "
            "where the scan has no data.",
    };
    const pc_album_page *page = &album->page[kind];
    if (!page->png) return;
    pc_html_print(html, "<figure><img alt=\"%s\" width=\"%d\" height=\"%d\" src=\"data:image/png;base64,",
                  pc_preview_name(kind), page->width, page->height);
    pc_html_base64(html, page->png, page->size);
    pc_html_put(html, "\"/><figcaption>");
    pc_html_put(html, caption[kind]);
    pc_html_put(html, "</figcaption></figure>\n");
}

static void put_card(pc_html *html, double value, bool count, const char *words) {
    pc_html_put(html, "<div><b>");
    if (count)
        pc_html_count(html, value);
    else
        pc_html_number(html, value);
    pc_html_print(html, "</b><span>%s</span></div>", words);
}

static void put_cards(pc_html *html, const pc_run *run, const pc_findings *findings) {
    const pc_quality *q = &findings->quality;
    double seconds = 0;
    size_t peak = 0;
    bool kept = false;
    for (int id = 0; id < PC_STAGE_EXPORT; id++) {
        const pc_stage_record *record = &run->record[id];
        seconds += record->wall_seconds;
        if (record->resident_peak > peak) peak = record->resident_peak;
        kept = kept || record->state == PC_STAGE_LOADED;
    }
    pc_html_put(html, "<div class=\"cards\">");
    if (findings->has_spline) {
        const pc_held_spline *held = findings->spline.held;
        put_card(html, held->surface.mesh.vertex_count, true, "control points");
        put_card(html, held->stats.accuracy.max, false, "largest distance, both ways");
    }
    if (findings->has_quality) {
        put_card(html, q->quads.faces, true, q->quad_cell_percent >= 100 ? "quads" : "cells");
        put_card(html, q->irregular_interior, true, "irregular vertices");
        if (!findings->has_spline)
            put_card(html, q->scan_to_quads.max, false, "largest distance from the scan to the quads");
    }
    pc_html_print(html, "<div><b class=\"time\">%.*f s</b><span class=\"time\">of computing%s</span></div>",
                  seconds < 10 ? 2 : 0, seconds, kept ? "; finished stages were kept" : "");
    pc_html_put(html, "<div><b class=\"time\">");
    pc_html_bytes(html, (double)peak);
    pc_html_put(html, "</b><span>memory at most</span></div></div>\n");
}

static void put_size_wish(pc_html *html, const pc_convert_options *o) {
    if (o->quads) {
        pc_html_count(html, (double)o->quads);
        pc_html_put(html, " quads");
    } else if (o->edge_length > 0) {
        pc_html_put(html, "quads with edges of ");
        pc_html_number(html, o->edge_length);
        pc_html_put(html, " in units of the scan");
    } else if (o->edge_factor > 0) {
        pc_html_put(html, "quads with edges of ");
        pc_html_number(html, o->edge_factor);
        pc_html_put(html, " mean edges of the scan");
    } else {
        pc_html_put(html, "quads of a size left to Percale");
    }
}

static bool wants_spline(const pc_convert_options *o) {
    return o->tolerance > 0 && o->last >= PC_STAGE_SPLINE;
}

static void put_spline_wish(pc_html *html, const pc_convert_options *o) {
    pc_html_put(html, "a spline surface within ");
    pc_html_number(html, o->tolerance_relative ? 100 * o->tolerance : o->tolerance);
    pc_html_put(html, o->tolerance_relative ? "&#8201;% of the diagonal" : " in units of the scan");
    if (!o->max_control_points) return;
    pc_html_put(html, ", at most ");
    pc_html_count(html, o->max_control_points);
    pc_html_put(html, " control points");
}

static void put_asked(pc_html *html, const pc_run *run) {
    static const char *const borders[] = {"not followed", "followed where smooth", "all followed"};
    const pc_convert_options *o = run->options;
    pc_html_put(html, "<h2>What was asked</h2>\n<div class=\"wide\"><table><tbody>\n");
    pc_html_row(html, "result");
    put_size_wish(html, o);
    pc_html_row_end(html);
    if (wants_spline(o)) {
        pc_html_row(html, "and");
        put_spline_wish(html, o);
        pc_html_row_end(html);
    }
    pc_html_row(html, "cells that are not quads");
    pc_html_put(html, o->keep_ngons ? "kept whole" : "split into quads");
    pc_html_row_end(html);
    pc_html_row(html, "sizes");
    pc_html_put(html, o->curl_correction ? "may vary for fewer irregular vertices" : "about equal");
    pc_html_row_end(html);
    pc_html_row(html, "borders");
    pc_html_put(html, borders[o->align_borders]);
    pc_html_row_end(html);
    if (o->smoothness >= 0) {
        pc_html_row(html, "smoothness of the directions");
        pc_html_number(html, o->smoothness);
        pc_html_row_end(html);
    }
    if (o->min_component > 1) {
        pc_html_row(html, "least number of faces of a piece");
        pc_html_count(html, o->min_component);
        pc_html_row_end(html);
    }
    pc_html_put(html, "</tbody></table></div>\n");
}

static void put_stage(pc_html *html, const pc_run *run, pc_stage_id id) {
    const pc_stage_record *record = &run->record[id];
    pc_html_put(html, "<tr><th>");
    pc_html_escape(html, pc_stage_title(id));
    pc_html_put(html, "</th><td>");
    pc_html_escape(html, record->note);
    pc_html_put(html, "</td><td class=\"n time\">");
    if (record->state == PC_STAGE_MADE)
        pc_html_print(html, "%.2f s</td><td class=\"n time\">", record->wall_seconds);
    else
        pc_html_put(html, "kept</td><td class=\"n time\">");
    if (record->state == PC_STAGE_MADE) pc_html_bytes(html, (double)record->resident_peak);
    pc_html_put(html, "</td></tr>\n");
}

static void put_stages(pc_html *html, const pc_run *run) {
    pc_html_put(html,
                "<h2>Stages</h2>\n<div class=\"wide\"><table><thead><tr><th>stage</th><th>what it found</th>"
                "<th class=\"n\">time</th><th class=\"n\">memory</th></tr></thead><tbody>\n");
    /* Parts leave no trace in the result, and how many there are is up to the machine. */
    for (int id = 0; id < PC_STAGE_EXPORT; id++)
        if (id != PC_STAGE_PARTS &&
            (run->record[id].state == PC_STAGE_MADE || run->record[id].state == PC_STAGE_LOADED))
            put_stage(html, run, (pc_stage_id)id);
    pc_html_put(html, "</tbody></table></div>\n");
}

static void put_pictures(pc_html *html, const pc_album *album) {
    bool any = false;
    for (int kind = 0; kind <= PC_PREVIEW_QUADS; kind++)
        any = any || album->page[kind].png;
    if (!any) return;
    pc_html_put(html, "<h2>From the scan to the quads</h2>\n<div class=\"stages\">\n");
    for (int kind = 0; kind <= PC_PREVIEW_QUADS; kind++)
        pc_html_figure(html, album, (pc_preview_kind)kind);
    pc_html_put(html, "</div>\n");
}

static void put_head(pc_html *html, const pc_run *run) {
    const char *name = base_name(run->scan_path);
    pc_html_put(html,
                "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"/><meta name=\"viewport\" "
                "content=\"width=device-width, initial-scale=1\"/>\n<title>");
    pc_html_escape(html, name);
    pc_html_put(html, " &#183; Percale</title>\n<style>\n");
    pc_html_put(html, pc_html_style);
    pc_html_put(html, "</style></head>\n<body><main>\n<header><h1>");
    pc_html_escape(html, name);
    pc_html_put(html, "</h1><p class=\"soft\">");
    pc_html_escape(html, run->record[PC_STAGE_SCAN].note);
    pc_html_put(html, "</p><p class=\"soft\">Asked of Percale ");
    pc_html_escape(html, pc_version());
    pc_html_put(html, ": ");
    put_size_wish(html, run->options);
    if (wants_spline(run->options)) {
        pc_html_put(html, "; ");
        put_spline_wish(html, run->options);
    }
    pc_html_put(html, ".</p></header>\n");
}

static void put_foot(pc_html *html, const pc_run *run) {
    pc_html_put(html, "<footer><p>");
    pc_html_escape(html, base_name(run->scan_path));
    pc_html_put(html, ": ");
    pc_html_count(html, (double)run->input_bytes);
    pc_html_put(html, " bytes, SHA-256 ");
    pc_html_escape(html, run->input_sha256);
    pc_html_put(html, "</p><p>Computed on ");
    pc_html_escape(html, pc_device_name(run->device));
    pc_html_print(html,
                  ", <span class=\"time\">%d thread%s</span>. All figures are in report.json.</p></footer>\n",
                  omp_get_max_threads(), omp_get_max_threads() == 1 ? "" : "s");
    pc_html_put(html, "</main></body></html>\n");
}

pc_status pc_html_report_make(pc_html *html, const pc_run *run, const pc_findings *findings,
                              const pc_album *album) {
    put_head(html, run);
    pc_html_verdict(html, run, findings);
    put_cards(html, run, findings);
    if (findings->has_spline) pc_html_spline(html, findings, album);
    put_pictures(html, album);
    if (findings->has_quality) {
        pc_html_quads(html, findings);
        pc_html_certificate(html, &findings->certificate);
    }
    put_asked(html, run);
    put_stages(html, run);
    put_foot(html, run);
    return pc_html_end(html);
}

pc_status pc_html_report_write(const pc_run *run, const pc_findings *findings, const pc_album *album) {
    pc_html html;
    char *path = NULL;
    pc_writer writer = {0};
    pc_status status = PC_OK;
    pc_html_start(&html, run->ctx);
    PC_TRY(pc_html_report_make(&html, run, findings, album));
    PC_TRY(pc_folder_join(&path, run->ctx, run->out, PC_OUT_PAGE, ""));
    PC_TRY(pc_writer_open(&writer, run->ctx, path, true));
    PC_TRY(pc_writer_put(&writer, html.text, html.length));
    PC_TRY(pc_writer_commit(&writer));
done:
    pc_writer_abandon(&writer);
    pc_free(run->ctx, path);
    pc_html_free(&html);
    return status;
}
