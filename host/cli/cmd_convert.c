#include "command.h"
#include "json.h"
#include "memory.h"
#include "progress.h"
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] = "convert SCAN -o OUT [OPTIONS]";
static const char about[] =
    "Turns the triangle scan SCAN (.ply .obj .stl .off, each also .gz) into a quad control mesh, and with\n"
    "--tolerance into a T-spline surface for CAD (surface.step).\n"
    "OUT is a folder; it receives quads.obj, quads.ply, quads.hdf, scan.hdf, result.h5, report.json and "
    "pictures,\n"
    "and in OUT/stages one HDF5 file per finished stage. Without -o it is told what would be done.";

/* What the options of the command line are read into. */
typedef struct convert_line {
    pc_convert_options options;
    const char *out, *last, *tolerance, *formats;
    int ngons, ragged, borders, pgp;
    uint64_t min_component, max_control_points, parts, threads;
    bool json, quiet, verbose, no_pictures;
} convert_line;

enum { QUADS, EDGE_LENGTH, EDGE_FACTOR }; /* places in the table */

static pc_status read_line(convert_line *line, pc_operands *operands, pc_context *ctx, int argc,
                           const char **argv) {
    pc_convert_options *o = &line->options;
    pc_option table[] = {
        [QUADS] = PC_COUNT("quads", &o->quads, "N", 1, 1e9,
                           "how many quads are wanted, such as 20000, 20k or 1.5M; met within 5 %"),
        [EDGE_LENGTH] = PC_NUMBER("edge-length", &o->edge_length, "X", 1e-300, INFINITY,
                                  "edge length of the quads, in the units of the scan"),
        [EDGE_FACTOR] = PC_NUMBER(
            "edge-factor", &o->edge_factor, "F", 0.1, 1e6,
            "edge length of the quads, in mean edge lengths of the scan (default 10, less where that "
            "would give fewer than 4000 quads, or half as "
            "many as there are triangles)"),
        PC_TEXT("tolerance", 0, &line->tolerance, "T",
                "make a smooth T-spline surface too, nowhere farther than T from the scan: 0.2% of the "
                "diagonal of its box, or 0.05 in its units"),
        PC_COUNT("max-control-points", &line->max_control_points, "N", 1, PC_NONE,
                 "of the T-spline (default: two per vertex of the scan)"),
        PC_TEXT("formats", 0, &line->formats, "LIST",
                "further files of the T-spline beside surface.step: iges,iga,bext,gismo, or all"),
        PC_TEXT("output", 'o', &line->out, "OUT", "the folder for the results"),
        PC_CHOICE("ngons", &line->ngons, "split|keep",
                  "cells that are not quads: split into quads (default), or kept whole"),
        PC_TEXT("device", 0, &o->device, "DEVICE",
                "cpu, gpu, P:D, part of a name, or host (plain C); see 'percale devices'. Several: A,B, or "
                "A/N for N sub-devices of A"),
        PC_FLAG("curl-correction", 0, &o->curl_correction,
                "let the size of the quads vary, for fewer irregular vertices"),
        PC_TEXT("to", 0, &line->last, "STAGE",
                "stop after scan, mesh, parts, curvature, field, curl, param, layout, quads or "
                "spline"),
        PC_FLAG("resume", 0, &o->resume, "keep the finished stages of an earlier run in OUT"),
        PC_FLAG("force", 0, &o->force, "overwrite the results of an earlier run in OUT"),
        PC_FLAG("strict", 0, &o->strict, "refuse edges with more than two faces instead of cutting them"),
        PC_COUNT("min-component", &line->min_component, "N", 0, PC_NONE,
                 "leave out pieces of fewer than N triangles (default 1: none)"),
        PC_CHOICE(
            "ragged", &line->ragged, "fill|keep",
            "borders in teeth of single triangles, and small holes with such: notches filled (default), or "
            "left as they are"),
        PC_NUMBER("smoothness", &o->smoothness, "R", 0, 0.9999,
                  "of the direction field: 0 follows the curvature, near 1 forgets it (default 0.8)"),
        PC_CHOICE("align-borders", &line->borders, "off|auto|all",
                  "run the field along borders: nowhere, where they are smooth (default), everywhere"),
        PC_CHOICE("pgp", &line->pgp, "normalise|newton",
                  "solver of the parameterization: normalise-and-solve steps (default), or the "
                  "thesis's penalty and Newton's method, slower"),
        PC_COUNT("parts", &line->parts, "K", 1, 1e6,
                 "pieces to cut the mesh into (default 1); changes no result"),
        PC_COUNT("threads", &line->threads, "T", 1, 4096, "CPU threads (default: all); changes no result"),
        PC_COUNT("seed", &o->seed, "S", 0, 0x1p53, "of the start of the solver (default 1)"),
        PC_FLAG("compress", 0, &o->compress, "compress the HDF5 files"),
        PC_FLAG("json", 0, &line->json, "print the report, or the plan, as JSON on standard output"),
        PC_FLAG("quiet", 'q', &line->quiet, "print errors only"),
        PC_FLAG("verbose", 'v', &line->verbose, "print more"),
        PC_FLAG("no-pictures", 0, &line->no_pictures, "draw no previews"),
        PC_OPTIONS_END,
    };
    pc_status status = pc_options_read(operands, ctx, table, argc, argv);
    if (status == PC_OK && operands->help_asked) pc_command_help(usage, about, table);
    if (status == PC_OK && table[QUADS].given + table[EDGE_LENGTH].given + table[EDGE_FACTOR].given > 1)
        status = pc_fail(ctx, PC_E_USAGE, "--quads, --edge-length and --edge-factor exclude each other");
    return status;
}

static pc_status find_stage(pc_stage_id *stage, pc_context *ctx, const char *option, const char *name) {
    const char *words[PC_STAGE_COUNT + 1];
    *stage = pc_stage_find(name);
    if (*stage < PC_STAGE_COUNT) return PC_OK;
    for (int i = 0; i < PC_STAGE_COUNT; i++)
        words[i] = pc_stage_title((pc_stage_id)i);
    words[PC_STAGE_COUNT] = NULL;
    const char *nearest = pc_nearest_word(name, words);
    return pc_fail(ctx, PC_E_USAGE, "%s: no stage is called '%s'%s%s%s", option, name,
                   nearest ? "; did you mean " : "", nearest ? nearest : "", nearest ? "?" : "");
}

static const char default_tolerance[] = "0.2%";

/* "0.2%" of the diagonal, or a length. */
static pc_status read_tolerance(pc_convert_options *options, pc_context *ctx, const char *text) {
    char *end;
    double value = strtod(text, &end);
    bool percent = end != text && strcmp(end, "%") == 0;
    if (end == text || (*end && !percent) || !(value > 0) || !isfinite(value))
        return pc_fail(ctx, PC_E_USAGE,
                       "--tolerance wants a distance above 0, such as 0.2%% of the diagonal or 0.05 in the "
                       "units of the scan, not '%s'",
                       text);
    options->tolerance = percent ? value / 100 : value;
    options->tolerance_relative = percent;
    return PC_OK;
}

/* "iges,iga": bits of pc_convert_options.spline_formats. */
static pc_status read_formats(pc_convert_options *options, pc_context *ctx, const char *text) {
    for (const char *word = text; *word; word += *word == ',') {
        size_t length = strcspn(word, ",");
        unsigned found = length == 3 && strncmp(word, "all", 3) == 0 ? (1U << PC_SPLINE_FORMATS) - 1 : 0;
        for (int format = 0; format < PC_SPLINE_FORMATS; format++) {
            const char *name = pc_spline_format_name((pc_spline_format)format);
            if (strlen(name) == length && strncmp(word, name, length) == 0) found = 1U << format;
        }
        if (!found)
            return pc_fail(ctx, PC_E_USAGE, "--formats wants some of iges,iga,bext,gismo, or all, not '%s'",
                           text);
        options->spline_formats |= found;
        word += length;
    }
    return PC_OK;
}

static pc_status finish_options(convert_line *line, pc_context *ctx) {
    pc_convert_options *options = &line->options;
    pc_status status = PC_OK;
    options->keep_ngons = line->ngons == 1;
    options->keep_ragged = line->ragged == 1;
    options->align_borders = line->borders;
    options->pgp = line->pgp;
    options->pictures = !line->no_pictures;
    options->min_component = (pc_index)line->min_component;
    options->parts = (pc_index)line->parts;
    options->max_control_points = (pc_index)line->max_control_points;
    if (line->last) PC_TRY(find_stage(&options->last, ctx, "--to", line->last));
    if (options->last == PC_STAGE_CURL) options->curl_correction = true;
    if (options->last == PC_STAGE_SPLINE && !line->tolerance) line->tolerance = default_tolerance;
    if (line->tolerance) PC_TRY(read_tolerance(options, ctx, line->tolerance));
    if (line->formats) PC_TRY(read_formats(options, ctx, line->formats));
    if (line->formats && !line->tolerance) {
        status = pc_fail(ctx, PC_E_USAGE, "--formats are those of the T-spline: --tolerance makes one");
        goto done;
    }
    const char *stop = getenv("PERCALE_STOP_AFTER"); /* a hook of the tests: CONTRIBUTING.md */
    if (stop) PC_TRY(find_stage(&options->stop_after, ctx, "PERCALE_STOP_AFTER", stop));
    if (line->threads) {
        char count[24];
        omp_set_num_threads((int)line->threads);
        /* PoCL reads this when it is first asked for its devices. */
        (void)snprintf(count, sizeof count, "%d", (int)line->threads);
        (void)setenv("POCL_MAX_PTHREAD_COUNT", count, 0);
    }
done:
    return status;
}

static void print_plan(const pc_convert_plan *plan, const char *scan, bool json_wanted, pc_json *json) {
    if (json_wanted) {
        pc_json_object(json, NULL);
        pc_json_string(json, "scan", scan);
        pc_json_integer(json, "vertices", (int64_t)plan->vertices);
        pc_json_integer(json, "triangles", (int64_t)plan->faces);
        pc_json_number(json, "mean_edge", plan->mean_edge);
        pc_json_number(json, "area", plan->area);
        pc_json_number(json, "edge_length", plan->edge_length);
        pc_json_integer(json, "quads", llround(plan->quads));
        pc_json_integer(json, "memory_bytes", llround(plan->memory_bytes));
        pc_json_integer(json, "disk_bytes", llround(plan->disk_bytes));
        pc_json_close(json);
        return;
    }
    (void)printf("%s: %llu triangles, %llu vertices, mean edge %.4g, area %.4g\n", scan,
                 (unsigned long long)plan->faces, (unsigned long long)plan->vertices, plan->mean_edge,
                 plan->area);
    (void)printf("would become about %.0f quads of edge length %.4g\n", plan->quads, plan->edge_length);
    (void)printf("and take about %.0f MB of memory and %.0f MB on disk\n", 1e-6 * plan->memory_bytes,
                 1e-6 * plan->disk_bytes);
    (void)printf("nothing is written; -o OUT converts\n");
}

static pc_status estimate(const convert_line *line, pc_context *ctx, const char *scan) {
    pc_convert_plan plan;
    pc_json json;
    pc_json_start(&json, ctx, false);
    pc_status status = pc_convert_estimate(&plan, ctx, scan, &line->options);
    if (status == PC_OK) print_plan(&plan, scan, line->json, &json);
    if (status == PC_OK && line->json) {
        status = pc_json_end(&json);
        if (status == PC_OK) (void)fputs(json.text, stdout);
    }
    pc_json_free(&json);
    return status;
}

static pc_status convert(convert_line *line, pc_context *ctx, const char *scan) {
    pc_progress_view view;
    char *report = NULL;
    pc_progress_start(&view, ctx, line->quiet, line->verbose);
    line->options.on_stage = pc_progress_stage;
    line->options.user = &view;
    pc_status status = pc_convert(&report, ctx, scan, line->out, &line->options);
    pc_progress_stop(&view, ctx);
    if (report && line->json) (void)fputs(report, stdout);
    if (status == PC_E_INTERRUPT && !line->quiet)
        (void)fprintf(stderr,
                      "percale: finished stages are kept in %s; the same command with --resume goes on\n",
                      line->out);
    pc_free(ctx, report);
    return status;
}

pc_status pc_command_convert(pc_context *ctx, int argc, const char **argv) {
    convert_line line = {.options = PC_CONVERT_DEFAULTS, .borders = 1, .min_component = 1, .parts = 1};
    pc_operands operands;
    pc_status status = PC_OK;
    PC_TRY(read_line(&line, &operands, ctx, argc, argv));
    if (operands.help_asked) goto done;
    PC_TRY(pc_command_operands(ctx, &operands, 1, usage));
    PC_TRY(finish_options(&line, ctx));
    status = line.out ? convert(&line, ctx, operands.text[0]) : estimate(&line, ctx, operands.text[0]);
done:
    return status;
}
