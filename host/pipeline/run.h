/* Converts a scan: runs the stages in order, keeps each product in a file, and reports. */
#ifndef PC_RUN_H
#define PC_RUN_H

#include "context.h"

typedef enum pc_stage_id {
    PC_STAGE_SCAN,
    PC_STAGE_MESH,
    PC_STAGE_PARTS,
    PC_STAGE_CURVATURE,
    PC_STAGE_FIELD,
    PC_STAGE_CURL,
    PC_STAGE_PARAM,
    PC_STAGE_LAYOUT,
    PC_STAGE_QUADS,
    PC_STAGE_SPLINE,
    PC_STAGE_EXPORT,
    PC_STAGE_COUNT
} pc_stage_id;

typedef enum pc_stage_state {
    PC_STAGE_PENDING, /* not reached */
    PC_STAGE_SKIPPED, /* not asked for */
    PC_STAGE_MADE,
    PC_STAGE_LOADED /* the file of an earlier run was taken */
} pc_stage_state;

typedef struct pc_stage_event {
    pc_stage_id stage;
    const char *name;
    int number, count; /* 1..count among the stages of this run */
    bool finished;     /* false: it begins */
    pc_stage_state state;
    double seconds;
    size_t peak_bytes; /* counted memory, while it ran */
    const char *note;  /* "42 singularities" */
} pc_stage_event;

typedef void pc_stage_sink(void *user, const pc_stage_event *event);

/* Without any wish the quads are ten mean edges of the scan long (digest C21), but where that would leave
 * fewer than these many of them (or half as many as triangles, on small scans) they are shorter. */
#define PC_DEFAULT_EDGE_FACTOR 10.0
#define PC_DEFAULT_LEAST_QUADS 4000.0
/* The same where a spline refines them afterwards. */
#define PC_SPLINE_LEAST_QUADS 1500.0

/* Files of the spline beside surface.step. */
typedef enum pc_spline_format {
    PC_SPLINE_IGES,
    PC_SPLINE_IGA,
    PC_SPLINE_BEXT,
    PC_SPLINE_GISMO,
    PC_SPLINE_FORMATS
} pc_spline_format;

typedef struct pc_convert_options {
    uint64_t quads;     /* how many are wanted; 0: by length */
    double edge_length; /* of the quads, model units; 0: by factor */
    double edge_factor; /* times the mean edge of the scan; 0: by default 10, see PC_DEFAULT_LEAST_QUADS */
    bool closer;        /* quads that a spline starts from follow the scan more closely than usual */
    int keep_ngons;     /* 1: cells that are not quads stay whole; 0: they are split into quads */
    const char *device; /* NULL: the default */
    bool curl_correction;
    pc_stage_id last;            /* stages after it are left out, export excepted */
    double tolerance;            /* of the spline: largest distance to the scan; 0: no spline */
    bool tolerance_relative;     /* the tolerance is a part of the diagonal of the scan's box, not a length */
    pc_index max_control_points; /* of the spline; 0: two per vertex of the scan */
    unsigned spline_formats;     /* bit 1 << pc_spline_format: that file too */
    bool resume;                 /* takes finished stages whose key fits */
    bool force;                  /* overwrites the outputs of an earlier run */
    bool strict;                 /* refuses what repair would have to cut */
    pc_index min_component;      /* components of fewer faces are dropped */
    bool keep_ragged;            /* notches of ragged borders are not filled */
    double smoothness;           /* rho of the field, 0..1; below 0: the field's default */
    int align_borders;           /* pc_align_borders */
    int pgp;                     /* pc_pgp_scheme */
    pc_index parts;              /* 0: by memory */
    uint64_t seed;
    bool compress; /* the HDF5 files */
    bool pictures;
    pc_stage_id stop_after; /* tests: be interrupted when this stage is finished; PC_STAGE_COUNT: never */
    pc_stage_sink *on_stage;
    void *user;
} pc_convert_options;
#define PC_CONVERT_DEFAULTS                                                                                  \
    {                                                                                                        \
        .smoothness = -1, .last = PC_STAGE_EXPORT, .min_component = 1, .seed = 1, .pictures = true,          \
        .stop_after = PC_STAGE_COUNT                                                                         \
    }

/* Converts the scan at `scan` into the folder `out`, which is made; what is there already is refused unless
 * `resume` or `force` is set (PC_E_USAGE). A spline that misses the tolerance is tried once more with
 * `closer`, and the better one is kept; not where the options say how large quads or how many control points
 * should be, nor above a million triangles. `*report` receives the text of report.json, freed with pc_free;
 * it is NULL on errors before the export. PC_E_NOCONV where a named check of the certificate failed: all
 * outputs are written then. PC_E_INTERRUPT where the user stopped it: finished stages stay in out/stages. */
pc_status pc_convert(char **report, pc_context *ctx, const char *scan, const char *out,
                     const pc_convert_options *options);

typedef struct pc_convert_plan {
    uint64_t vertices, faces; /* of the scan, repaired */
    double mean_edge, area;
    double edge_length;  /* of the quads to come */
    double quads;        /* their estimated number */
    double memory_bytes; /* estimated peak */
    double disk_bytes;   /* estimated size of the outputs */
} pc_convert_plan;

/* What pc_convert would do. Reads and repairs the scan, writes nothing. */
pc_status pc_convert_estimate(pc_convert_plan *plan, pc_context *ctx, const char *scan,
                              const pc_convert_options *options);

/* "scan", "mesh", ... */
const char *pc_stage_title(pc_stage_id stage);
/* "iges", "iga", ... */
const char *pc_spline_format_name(pc_spline_format format);
/* PC_STAGE_COUNT where no stage has this name. */
pc_stage_id pc_stage_find(const char *name);

#endif
