#include "html_parts.h"
#include <string.h>

static const struct {
    const char *check, *words;
} advice[] = {
    {"manifold",
     "The mesh has faults that programs after this one may refuse. Another number of quads mostly "
     "helps (--quads)."},
    {"broken cells", "These faces are no cells. Another number of quads mostly helps (--quads)."},
    {"components", "Pieces of the scan were lost or joined. Ask for more quads (--quads, --edge-length); "
                   "--min-component leaves out small pieces on purpose."},
    {"Euler number", "A handle or a hole was lost or added: it is smaller than a cell. Ask for more quads."},
    {"boundary loops",
     "A hole was closed or opened: it is smaller than a cell. Ask for more quads, or mend the "
     "scan there."},
    {"inverted cells",
     "Look at the cells named here, mostly along ragged holes or in creases. More quads help "
     "more often than not."},
    {"zero-area cells", "Look at the cells named here. More quads help more often than not."},
    {"face count", "A count is met in whole strips of quads. Take what came out, or ask for another count."},
    {"no part dropped",
     "A feature of the scan is smaller than a cell and was lost. Ask for more quads (--quads, "
     "--edge-length)."},
    {"no part added", "Quads span something that is not there in the scan, mostly across a gap. Ask for more "
                      "quads."},
    {"surface area", "The quads fold, or cut much of the scan short. Ask for more quads."},
    {"spline tolerance",
     "The surface is as near as it got. Allow more control points (--max-control-points), "
     "begin with more quads (--quads), or take a tolerance above the noise of the scan; the "
     "pictures below show where it is off."},
};

static const char *advice_on(const char *check) {
    for (size_t i = 0; i < sizeof advice / sizeof *advice; i++)
        if (strcmp(advice[i].check, check) == 0) return advice[i].words;
    return "This should not happen: please report it, with the scan if you can.";
}

static int failed_checks(const pc_certificate *certificate) {
    int failed = 0;
    for (int i = 0; i < certificate->count; i++)
        failed += !certificate->check[i].passed;
    return failed;
}

static void put_failures(pc_html *html, const pc_certificate *certificate) {
    pc_html_put(html, "<ul>");
    for (int i = 0; i < certificate->count; i++) {
        const pc_check *check = &certificate->check[i];
        if (check->passed) continue;
        pc_html_put(html, "<li><b>");
        pc_html_escape(html, check->name);
        pc_html_put(html, "</b>: found ");
        pc_html_number(html, check->value);
        pc_html_put(html, ", expected ");
        pc_html_number(html, check->expected);
        pc_html_put(html, ". ");
        pc_html_put(html, advice_on(check->name));
        pc_html_put(html, "</li>");
    }
    pc_html_put(html, "</ul>");
}

/* The first thing to read: whether this is what was asked for. */
void pc_html_verdict(pc_html *html, const pc_run *run, const pc_findings *findings) {
    const pc_certificate *certificate = &findings->certificate;
    const pc_held_spline *held = findings->spline.held;
    if (!findings->has_quality) {
        pc_html_put(html, "<div class=\"verdict open\"><strong>Stopped as asked after the stage ");
        pc_html_escape(html, pc_stage_title(run->options->last));
        pc_html_put(html, ".</strong>There is no result yet that could be judged.</div>\n");
        return;
    }
    int failed = failed_checks(certificate);
    pc_html_print(html, "<div class=\"verdict%s\"><strong>", failed ? " failed" : "");
    if (failed)
        pc_html_print(html, "Not as asked: %d of %d checks failed.", failed, certificate->count);
    else
        pc_html_print(html, "As asked: all %d checks passed.", certificate->count);
    pc_html_put(html, "</strong>");
    if (findings->has_spline) {
        pc_html_put(html, "The surface is nowhere farther than ");
        pc_html_number(html, held->stats.accuracy.max);
        pc_html_print(html, " from the scan, %.3g&#8201;%% of its diagonal; the tolerance was ",
                      100 * held->stats.accuracy.max / held->diagonal);
        pc_html_number(html, held->tolerance);
        pc_html_put(html, ". ");
    }
    if (failed)
        pc_html_put(html, "All files are written. What can be done:");
    else
        pc_html_put(html, "What no check can tell is whether you like it: look at the pictures.");
    if (failed) put_failures(html, certificate);
    pc_html_put(html, "</div>\n");
}

void pc_html_certificate(pc_html *html, const pc_certificate *certificate) {
    pc_html_put(html,
                "<h2>Certificate</h2>\n<div class=\"wide\"><table><thead><tr><th>check</th><th></th><th "
                "class=\"n\">found</th><th class=\"n\">expected</th><th>what it "
                "is</th></tr></thead><tbody>\n");
    for (int i = 0; i < certificate->count; i++) {
        const pc_check *check = &certificate->check[i];
        pc_html_put(html, "<tr><th>");
        pc_html_escape(html, check->name);
        pc_html_put(html, check->passed ? "</th><td class=\"good\">passed" : "</th><td class=\"bad\">failed");
        pc_html_put(html, "</td><td class=\"n\">");
        pc_html_number(html, check->value);
        pc_html_put(html, "</td><td class=\"n\">");
        pc_html_number(html, check->expected);
        pc_html_put(html, "</td><td>");
        pc_html_escape(html, check->note);
        pc_html_put(html, "</td></tr>\n");
    }
    pc_html_put(html, "</tbody></table></div>\n");
}
