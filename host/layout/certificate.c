#include "certificate.h"
#include <stdio.h>
#include <string.h>

pc_check *pc_certificate_add(pc_certificate *c, const char *name, double value, double expected,
                             bool passed) {
    pc_check *check = c->check + c->count++;
    *check = (pc_check){.name = name, .value = value, .expected = expected, .passed = passed};
    c->passed = c->passed && passed;
    return check;
}

static void check_topology(pc_certificate *c, const pc_quality *q) {
    const pc_surface_count *quads = &q->quads, *scan = &q->scan;
    double faults = (double)quads->overfull_edges + quads->clashing_edges + quads->split_vertices +
                    quads->unused_vertices;
    pc_check *check = pc_certificate_add(c, "manifold", faults, 0, faults == 0);
    (void)snprintf(check->note, sizeof check->note,
                   "edges: %u overfull, %u clashing; vertices: %u with two fans, %u unused",
                   quads->overfull_edges, quads->clashing_edges, quads->split_vertices,
                   quads->unused_vertices);
    double broken = (double)quads->broken_faces + q->wild_vertices;
    check = pc_certificate_add(c, "broken cells", broken, 0, broken == 0 && quads->faces > 0);
    (void)snprintf(check->note, sizeof check->note,
                   "%u faces repeat a vertex or lack one, %u vertices not finite", quads->broken_faces,
                   q->wild_vertices);
    pc_certificate_add(c, "components", quads->components, scan->components,
                       quads->components == scan->components);
    pc_certificate_add(c, "Euler number", (double)quads->chi, (double)scan->chi, quads->chi == scan->chi);
    check = pc_certificate_add(c, "boundary loops", quads->loops, scan->loops, quads->loops == scan->loops);
    (void)snprintf(check->note, sizeof check->note, "%u boundary edges of %u", quads->boundary_edges,
                   quads->edges);
}

static void check_cells(pc_certificate *c, const pc_quality *q) {
    pc_check *check = pc_certificate_add(c, "inverted cells", q->inverted, 0, q->inverted == 0);
    if (q->inverted)
        (void)snprintf(check->note, sizeof check->note, "the first is face %u", q->first_inverted);
    check = pc_certificate_add(c, "zero-area cells", q->zero_area, 0, q->zero_area == 0);
    if (q->zero_area)
        (void)snprintf(check->note, sizeof check->note, "the first is face %u", q->first_zero_area);
}

static void check_field(pc_certificate *c, const pc_quality *q, const pc_field *field) {
    int64_t sum = 0;
    pc_index singular = 0;
    if (!field) return;
    for (pc_index f = 0; f < field->face_count && field->index; f++) {
        sum += field->index[f];
        singular += field->index[f] != 0;
    }
    for (pc_index l = 0; l < field->loop_count && field->loop_index; l++)
        sum += field->loop_index[l];
    double expected = (double)field->symmetry * (double)q->scan.chi;
    pc_check *check =
        pc_certificate_add(c, "singularity sum", (double)sum, expected, (double)sum == expected);
    (void)snprintf(check->note, sizeof check->note,
                   "in units of 1/%d turn, over %u singular faces and %u loops", field->symmetry, singular,
                   field->loop_count);
}

static void check_count(pc_certificate *c, const pc_quality *q, const pc_certificate_options *options) {
    if (!(options->faces_asked > 0)) return;
    double miss = q->quads.faces / options->faces_asked - 1;
    pc_check *check = pc_certificate_add(c, "face count", q->quads.faces, options->faces_asked,
                                         fabs(miss) <= options->faces_tolerance);
    (void)snprintf(check->note, sizeof check->note, "%+.1f %%, allowed are %.1f %%", 100 * miss,
                   100 * options->faces_tolerance);
}

static void check_distance(pc_certificate *c, const pc_quality *q, const pc_certificate_options *options) {
    double edge = options->edge_length > 0 ? options->edge_length : q->shape.edge_length.mean;
    double limit = options->reach * edge;
    bool measured = q->wild_vertices == 0;
    double there = q->worst_component, back = q->quads_to_scan.max;
    pc_check *check = pc_certificate_add(c, "no part dropped", there, limit,
                                         measured && there <= limit && q->missed_components == 0);
    (void)snprintf(check->note, sizeof check->note,
                   "scan to quads, largest; %u components have no face near them", q->missed_components);
    check = pc_certificate_add(c, "no part added", back, limit, measured && back <= limit);
    (void)snprintf(check->note, sizeof check->note, "quads to scan, largest");
}

/* A result can touch every part of the scan and still be a heap of folds, or a shred of it. */
static void check_area(pc_certificate *c, const pc_quality *q) {
    double part = q->quads_area / q->scan_area;
    pc_check *check = pc_certificate_add(
        c, "surface area", part, 1, part >= PC_CERTIFICATE_LEAST_AREA && part <= PC_CERTIFICATE_MOST_AREA);
    (void)snprintf(check->note, sizeof check->note, "quads / scan, allowed are %.2f to %.2f",
                   PC_CERTIFICATE_LEAST_AREA, PC_CERTIFICATE_MOST_AREA);
}

void pc_certificate_make(pc_certificate *certificate, const pc_quality *quality, const pc_field *field,
                         const pc_certificate_options *options) {
    *certificate = (pc_certificate){.passed = true};
    check_topology(certificate, quality);
    check_cells(certificate, quality);
    check_field(certificate, quality, field);
    check_count(certificate, quality, options);
    check_distance(certificate, quality, options);
    check_area(certificate, quality);
}

const pc_check *pc_certificate_find(const pc_certificate *certificate, const char *name) {
    for (int i = 0; i < certificate->count; i++)
        if (strcmp(certificate->check[i].name, name) == 0) return certificate->check + i;
    return NULL;
}
