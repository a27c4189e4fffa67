/* Times of everything that happens to a scan before its curvature: read, repair, adjacency, topology, order,
 * parts. bench_mesh SCAN [PARTS] prints one line per step, with what came out. */
#include "clock.h"
#include "halo.h"
#include "inspect.h"
#include "memory.h"
#include "order.h"
#include "scan.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bench {
    pc_context *ctx;
    pc_mesh raw, mesh, ordered;
    pc_repair_report report;
    pc_adjacency adjacency;
    pc_graph graph;
    pc_order order;
    pc_parts parts;
    pc_halo halo;
    pc_topology topology;
    double since, cpu_since;
} bench;

static void begin(bench *b) {
    b->since = pc_clock_wall(), b->cpu_since = pc_clock_cpu();
}

static void tell(bench *b, const char *step) {
    double now = pc_clock_wall(), cpu = pc_clock_cpu();
    printf("%-12s %8.3f s  %8.3f s CPU  peak %7.1f MB\n", step, now - b->since, cpu - b->cpu_since,
           (double)pc_memory_peak(b->ctx) / 1e6);
    pc_memory_reset_peak(b->ctx);
    begin(b);
}

static void tell_defect(const char *what, const pc_defect *defect) {
    if (!defect->count) return;
    printf("  %u %s:", defect->count, what);
    for (pc_index i = 0; i < defect->count && i < PC_DEFECT_IDS; i++)
        printf(" %u", defect->id[i]);
    printf("\n");
}

static void tell_report(const pc_repair_report *r) {
    tell_defect("merged vertices", &r->merged_vertices);
    tell_defect("isolated vertices", &r->isolated_vertices);
    tell_defect("degenerate faces", &r->degenerate_faces);
    tell_defect("duplicate faces", &r->duplicate_faces);
    tell_defect("crowded edges", &r->crowded_edges);
    tell_defect("torn edges", &r->torn_edges);
    tell_defect("flipped faces", &r->flipped_faces);
    tell_defect("split vertices", &r->split_vertices);
    tell_defect("cut vertices", &r->cut_vertices);
    tell_defect("cut edges", &r->cut_edges);
    tell_defect("dropped faces", &r->dropped_faces);
    tell_defect("zero-area faces", &r->zero_area_faces);
    if (r->cured_zero_area) printf("  %u of them cured\n", r->cured_zero_area);
}

static pc_status prepare(bench *b, const char *path) {
    pc_status status = PC_OK;
    pc_scan_info info;
    const pc_repair_options options = PC_REPAIR_DEFAULTS;
    begin(b);
    PC_TRY(pc_scan_read(&b->raw, &info, b->ctx, path));
    tell(b, "read");
    PC_TRY(pc_repair(&b->mesh, &b->report, b->ctx, &b->raw, &options));
    tell(b, "repair");
    tell_report(&b->report);
    PC_TRY(pc_adjacency_make(&b->adjacency, b->ctx, &b->mesh));
    tell(b, "adjacency");
    PC_TRY(pc_topology_make(&b->topology, b->ctx, &b->mesh, &b->adjacency));
    tell(b, "topology");
    PC_TRY(pc_topology_check(&b->topology, b->ctx, &b->mesh, &b->adjacency));
    printf("  %u vertices, %u faces, %u components, chi %lld, genus %llu, %u loops with %u edges\n",
           b->mesh.vertex_count, b->mesh.face_count, b->topology.component_count, (long long)b->topology.chi,
           (unsigned long long)b->topology.genus, b->topology.loop_count, b->adjacency.boundary_edge_count);
done:
    return status;
}

static pc_status arrange(bench *b, pc_index part_count) {
    pc_status status = PC_OK;
    pc_bandwidth before, after;
    begin(b);
    PC_TRY(pc_graph_make(&b->graph, b->ctx, &b->mesh, &b->adjacency));
    tell(b, "graph");
    PC_TRY(pc_order_make(&b->order, b->ctx, &b->mesh, &b->graph));
    tell(b, "order");
    PC_TRY(pc_order_apply(&b->ordered, b->ctx, &b->order, &b->mesh));
    tell(b, "apply");
    before = pc_order_bandwidth(&b->graph);
    pc_graph_free(&b->graph, b->ctx);
    pc_adjacency_free(&b->adjacency, b->ctx);
    begin(b);
    PC_TRY(pc_adjacency_make(&b->adjacency, b->ctx, &b->ordered));
    tell(b, "adjacency");
    PC_TRY(pc_graph_make(&b->graph, b->ctx, &b->ordered, &b->adjacency));
    tell(b, "graph");
    after = pc_order_bandwidth(&b->graph);
    printf("  mean distance of neighbours %.0f before, %.0f after\n", before.mean, after.mean);
    begin(b);
    PC_TRY(pc_parts_make(&b->parts, b->ctx, &b->graph, part_count));
    tell(b, "parts");
    PC_TRY(pc_halo_make(&b->halo, b->ctx, &b->graph, &b->parts));
    tell(b, "halo");
    printf("  %u parts, %llu edges between them, %u vertices in halos\n", part_count,
           (unsigned long long)b->parts.cut_edges, b->halo.halo_start[part_count]);
done:
    return status;
}

static pc_status inspect(bench *b) {
    pc_inspection i;
    const pc_repair_options options = PC_REPAIR_DEFAULTS;
    begin(b);
    pc_status status = pc_inspect(&i, b->ctx, &b->raw, &options);
    if (status != PC_OK) return status;
    tell(b, "inspect");
    printf("  convertible %d %s\n  edges %g .. %g .. %g, angles %g .. %g, valences %u .. %u\n", i.convertible,
           i.refusal, i.edge_length.min, i.edge_length.median, i.edge_length.max, i.angle.min, i.angle.max,
           i.valence_least, i.valence_most);
    pc_inspection_free(&i, b->ctx);
    return PC_OK;
}

int main(int argc, char **argv) {
    bench b = {.ctx = pc_context_make()};
    if (argc < 2 || !b.ctx) {
        (void)fprintf(stderr, "usage: bench_mesh SCAN [PARTS]\n");
        return 2;
    }
    long parts = argc > 2 ? strtol(argv[2], NULL, 10) : 16;
    pc_status status = prepare(&b, argv[1]);
    if (status == PC_OK) status = arrange(&b, (pc_index)parts);
    if (status == PC_OK) status = inspect(&b);
    if (status != PC_OK) (void)fprintf(stderr, "%s\n", pc_context_message(b.ctx));
    pc_halo_free(&b.halo, b.ctx);
    pc_parts_free(&b.parts, b.ctx);
    pc_graph_free(&b.graph, b.ctx);
    pc_order_free(&b.order, b.ctx);
    pc_topology_free(&b.topology, b.ctx);
    pc_adjacency_free(&b.adjacency, b.ctx);
    pc_repair_report_free(&b.report, b.ctx);
    pc_mesh_free(&b.ordered, b.ctx);
    pc_mesh_free(&b.mesh, b.ctx);
    pc_mesh_free(&b.raw, b.ctx);
    pc_context_free(b.ctx);
    return pc_status_exit_code(status);
}
