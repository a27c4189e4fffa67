#include "command.h"
#include "inspect.h"
#include "json.h"
#include "repair_facts.h"
#include "scan.h"

static const char usage[] = "check SCAN [--json]";
static const char about[] =
    "Tells what a scan is like, what repair would do to it, and whether it can be converted.\n"
    "Exit code 0: it can; 3: it cannot be read; 4: it is no surface that can be converted.";

static void put_spread(pc_json *json, const char *key, const pc_spread *spread) {
    pc_json_flat_object(json, key);
    pc_json_number(json, "min", spread->min);
    pc_json_number(json, "q05", spread->q05);
    pc_json_number(json, "median", spread->median);
    pc_json_number(json, "mean", spread->mean);
    pc_json_number(json, "q95", spread->q95);
    pc_json_number(json, "max", spread->max);
    pc_json_close(json);
}

static void put_components(pc_json *json, const pc_topology *topology) {
    pc_json_array(json, "components");
    for (pc_index i = 0; i < topology->component_count; i++) {
        const pc_component *c = &topology->component[i];
        pc_json_flat_object(json, NULL);
        pc_json_integer(json, "first_face", c->first_face);
        pc_json_integer(json, "vertices", c->vertex_count);
        pc_json_integer(json, "faces", c->face_count);
        pc_json_integer(json, "genus", c->genus);
        pc_json_integer(json, "boundary_loops", c->loop_count);
        pc_json_integer(json, "euler_number", c->chi);
        pc_json_number(json, "area", c->area);
        pc_json_close(json);
    }
    pc_json_close(json);
}

static pc_status print_json(pc_context *ctx, const char *path, const pc_scan_info *info,
                            const pc_inspection *in) {
    pc_json json;
    pc_json_start(&json, ctx, false);
    pc_json_object(&json, NULL);
    pc_json_string(&json, "scan", path);
    pc_json_object(&json, "file");
    pc_facts_put_file(&json, info);
    pc_json_close(&json);
    pc_json_boolean(&json, "convertible", in->convertible);
    if (!in->convertible) pc_json_string(&json, "refusal", in->refusal);
    pc_facts_put_repair(&json, "repair", &in->repair);
    pc_json_integer(&json, "vertices", in->mesh.vertex_count);
    pc_json_integer(&json, "edges", in->edge_count);
    pc_json_integer(&json, "triangles", in->mesh.face_count);
    pc_json_integer(&json, "euler_number", in->topology.chi);
    pc_json_integer(&json, "genus", (int64_t)in->topology.genus);
    pc_json_integer(&json, "boundary_loops", in->topology.loop_count);
    pc_json_integer(&json, "boundary_edges", in->boundary_edge_count);
    pc_json_number(&json, "area", in->area);
    if (in->boundary_edge_count == 0) pc_json_number(&json, "volume", in->volume);
    pc_json_number(&json, "diagonal", in->diagonal);
    put_spread(&json, "edge_length", &in->edge_length);
    put_spread(&json, "angle_degrees", &in->angle);
    put_spread(&json, "least_angle_degrees", &in->least_angle);
    put_components(&json, &in->topology);
    pc_json_close(&json);
    pc_status status = pc_json_end(&json);
    if (status == PC_OK) (void)fputs(json.text, stdout);
    pc_json_free(&json);
    return status;
}

static void print_spread(const char *title, const pc_spread *spread) {
    (void)printf("%-14s min %.4g, 5 %% %.4g, median %.4g, mean %.4g, 95 %% %.4g, max %.4g\n", title,
                 spread->min, spread->q05, spread->median, spread->mean, spread->q95, spread->max);
}

static void print_components(const pc_topology *topology) {
    enum { MOST = 20 };
    (void)printf("%-14s %u\n", "components", topology->component_count);
    if (topology->component_count < 2) return;
    for (pc_index i = 0; i < topology->component_count && i < MOST; i++) {
        const pc_component *c = &topology->component[i];
        (void)printf("    from face %-9u %9u triangles, genus %u, %u boundary loops, area %.4g\n",
                     c->first_face, c->face_count, c->genus, c->loop_count, c->area);
    }
    if (topology->component_count > MOST) (void)printf("    ... --json lists all\n");
}

static void print_text(const char *path, const pc_scan_info *info, const pc_inspection *in) {
    char line[512];
    (void)printf("%-14s %s\n", "file", path);
    (void)printf("%-14s %s%s, %zu vertices, %zu faces", "format", info->format, info->gzip ? ", gzip" : "",
                 info->vertex_count, info->face_count);
    if (info->polygon_count) (void)printf(", of them %zu polygons", info->polygon_count);
    if (info->ignored[0]) (void)printf("; not used: %s", info->ignored);
    (void)printf("\n");
    pc_facts_repair_line(line, sizeof line, &in->repair);
    (void)printf("%-14s %s\n", "repair", line[0] ? line : "nothing to do");
    (void)printf("%-14s %u vertices, %u edges, %u triangles\n", "surface", in->mesh.vertex_count,
                 in->edge_count, in->mesh.face_count);
    print_components(&in->topology);
    (void)printf("%-14s chi %lld, genus %llu, %u boundary loops with %u edges\n", "topology",
                 (long long)in->topology.chi, (unsigned long long)in->topology.genus, in->topology.loop_count,
                 in->boundary_edge_count);
    (void)printf("%-14s %.6g x %.6g x %.6g, diagonal %.6g, area %.6g\n", "size",
                 in->box.high.x - in->box.low.x, in->box.high.y - in->box.low.y,
                 in->box.high.z - in->box.low.z, in->diagonal, in->area);
    print_spread("edge length", &in->edge_length);
    print_spread("angle", &in->angle);
    print_spread("least angle", &in->least_angle);
    (void)printf("%-14s %s\n", "convertible", in->convertible ? "yes" : "no");
}

static pc_status check_scan(pc_context *ctx, const char *path, const pc_repair_options *options,
                            bool json_wanted) {
    pc_mesh raw = {0};
    pc_scan_info info;
    pc_inspection inspection = {0};
    pc_status status = PC_OK;
    PC_TRY(pc_scan_read(&raw, &info, ctx, path));
    PC_TRY(pc_inspect(&inspection, ctx, &raw, options));
    if (json_wanted)
        PC_TRY(print_json(ctx, path, &info, &inspection));
    else
        print_text(path, &info, &inspection);
    if (!inspection.convertible) status = pc_fail(ctx, PC_E_MESH, "%s: %s", path, inspection.refusal);
done:
    pc_inspection_free(&inspection, ctx);
    pc_mesh_free(&raw, ctx);
    return status;
}

pc_status pc_command_check(pc_context *ctx, int argc, const char **argv) {
    bool json_wanted = false, strict = false;
    uint64_t min_component = 1;
    pc_option table[] = {
        PC_FLAG("json", 0, &json_wanted, "print JSON"),
        PC_FLAG("strict", 0, &strict, "as convert: refuse edges with more than two faces"),
        PC_COUNT("min-component", &min_component, "N", 0, PC_NONE,
                 "as convert: leave out pieces of fewer than N triangles"),
        PC_OPTIONS_END,
    };
    pc_operands operands;
    pc_status status = PC_OK;
    PC_TRY(pc_options_read(&operands, ctx, table, argc, argv));
    if (operands.help_asked) {
        pc_command_help(usage, about, table);
        goto done;
    }
    PC_TRY(pc_command_operands(ctx, &operands, 1, usage));
    pc_repair_options options = PC_REPAIR_DEFAULTS;
    options.strict = strict, options.min_component = (pc_index)min_component;
    PC_TRY(check_scan(ctx, operands.text[0], &options, json_wanted));
done:
    return status;
}
