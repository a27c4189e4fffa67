/* The histogram of distances, drawn by hand: parts on a logarithmic scale, since the few far samples are what
 * one looks for. */
#include "html_parts.h"
#include <math.h>

enum { LEFT = 56, RIGHT = 704, TOP = 16, BOTTOM = 216 };
static const double least_part = 1e-5; /* of the scale */

static double column_of(const pc_errors *errors, double distance) {
    return LEFT + (RIGHT - LEFT) * distance / errors->high;
}

static double row_of(double part) {
    double up = part > least_part ? 1 - log10(part) / log10(least_part) : 0;
    return BOTTOM - (BOTTOM - TOP) * up;
}

static void put_scale(pc_html *html) {
    for (int k = 0; k <= 5; k++) {
        double part = pow(10, -k), y = row_of(part);
        pc_html_print(html,
                      "<line class=\"grid\" x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\"/>"
                      "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%g&#8201;%%</text>",
                      LEFT, RIGHT, y, y, LEFT - 8, y + 4, 100 * part);
    }
}

static void put_axis(pc_html *html, const pc_errors *errors) {
    double power = pow(10, floor(log10(errors->high / 5))), times = errors->high / 5 / power;
    double step = power * (times < 1.5 ? 1 : times < 3.5 ? 2 : times < 7.5 ? 5 : 10);
    for (int k = 0; k < 12 && k * step <= errors->high * (1 + 1e-9); k++) {
        double x = column_of(errors, k * step);
        pc_html_print(html,
                      "<line class=\"grid\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\"/>"
                      "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.3g</text>",
                      x, x, BOTTOM, BOTTOM + 5, x, BOTTOM + 19, k * step);
    }
    pc_html_print(html,
                  "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">distance, in the units of the scan</text>",
                  (LEFT + RIGHT) / 2, BOTTOM + 38);
}

static void put_bars(pc_html *html, const pc_errors *errors, double tolerance) {
    const double width = (double)(RIGHT - LEFT) / PC_ERRORS_BINS;
    for (int k = 0; k < PC_ERRORS_BINS; k++) {
        double y = row_of(errors->surface[k]), low = errors->high * k / PC_ERRORS_BINS;
        if (y >= BOTTOM) continue;
        pc_html_print(html, "<rect class=\"%s\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>",
                      tolerance > 0 && low >= tolerance * (1 - 1e-9) ? "over" : "bar", LEFT + width * k + 0.5,
                      y, width - 1, BOTTOM - y);
    }
}

static void put_scan_line(pc_html *html, const pc_errors *errors) {
    const double width = (double)(RIGHT - LEFT) / PC_ERRORS_BINS;
    pc_html_put(html, "<path class=\"scan\" d=\"");
    for (int k = 0; k < PC_ERRORS_BINS; k++) {
        double y = row_of(errors->scan[k]);
        pc_html_print(html, "%c%.1f %.1fH%.1f", k ? 'L' : 'M', LEFT + width * k, y, LEFT + width * (k + 1));
    }
    pc_html_put(html, "\"/>");
}

static void put_tolerance(pc_html *html, const pc_errors *errors, double tolerance) {
    double x = column_of(errors, tolerance);
    bool right = x > RIGHT - 100;
    pc_html_print(html,
                  "<line class=\"mark\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\"/>"
                  "<text class=\"strong\" x=\"%.1f\" y=\"%d\" text-anchor=\"%s\">tolerance</text>",
                  x, x, TOP - 8, BOTTOM, x + (right ? -7 : 7), TOP + 4, right ? "end" : "start");
}

void pc_html_histogram(pc_html *html, const pc_errors *errors, double tolerance) {
    pc_html_put(html, "<figure><div class=\"drawing\"><svg viewBox=\"0 0 720 264\" role=\"img\" "
                      "aria-label=\"Histogram of the distances\">");
    put_scale(html);
    put_bars(html, errors, tolerance);
    put_scan_line(html, errors);
    put_axis(html, errors);
    if (tolerance > 0) put_tolerance(html, errors, tolerance);
    pc_html_put(html,
                "</svg></div><figcaption><b>How the distances are spread.</b> Bars: from the surface to the "
                "scan, as parts of its area. Line: from ");
    pc_html_count(html, (double)errors->scan_count);
    pc_html_put(html, " vertices of the scan to the surface. The scale of the parts is logarithmic.");
    if (errors->largest > errors->high) {
        pc_html_put(html, " The last bin holds all that is more; the largest is ");
        pc_html_number(html, errors->largest);
        pc_html_put(html, ".");
    }
    pc_html_put(html, "</figcaption>"
                      "</figure>");
}
