/* The stages of a conversion: a static table that the run walks along. A stage is plugged in by one row. */
#ifndef PC_STAGE_H
#define PC_STAGE_H

#include "file.h"
#include "held.h"
#include "json.h"
#include "products.h"
#include "run.h"
#include "sha256.h"

typedef struct pc_stage_record {
    pc_stage_state state;
    double wall_seconds, cpu_seconds;
    size_t counted_peak;  /* bytes allocated through the context while it ran */
    size_t resident_peak; /* bytes of the process while it ran */
    char note[160];       /* what the user sees behind the stage */
    char *facts;          /* JSON object: what the stage found; the same for the same product */
} pc_stage_record;

/* What one kernel did in one stage. */
typedef struct pc_kernel_record {
    pc_stage_id stage;
    pc_kernel_stats stats;
} pc_kernel_record;

typedef struct pc_run {
    pc_context *ctx;
    const pc_convert_options *options;
    const char *scan_path;
    const char *out; /* NULL: nothing is written */
    pc_file input;   /* open until the scan is read */
    char input_sha256[PC_SHA256_TEXT];
    uint64_t input_bytes;
    pc_device *device;
    bool kept[PC_STAGE_COUNT]; /* an earlier run left its file */
    bool held[PC_STAGE_COUNT]; /* the product is in memory */
    char key[PC_STAGE_COUNT][PC_SHA256_TEXT];
    pc_stage_record record[PC_STAGE_COUNT];
    pc_kernel_record *kernels;
    size_t kernel_count;
    double earlier_error; /* of the spline's try before this one; 0: this is the first */
    pc_held product;
} pc_run;

typedef struct pc_stage {
    const char *name;
    int version;    /* raised whenever equal inputs give other bytes */
    unsigned needs; /* PC_NEEDS(...) of the stages whose products it reads */
    /* False: the options do not ask for it, and those that need it do without. NULL: always asked for. */
    bool (*wanted)(const pc_convert_options *options);
    /* Members for the options that its product depends on. NULL: none. */
    void (*options)(pc_json *json, const pc_convert_options *options);
    /* Fills its product and the note; may add facts. */
    pc_status (*make)(pc_run *run, pc_json *facts);
    pc_status (*check)(pc_run *run);
    pc_status (*save)(pc_run *run, pc_store *store);
    pc_status (*load)(pc_run *run, pc_store *store);
    void (*drop)(pc_run *run);
} pc_stage;

#define PC_NEEDS(stage) (1U << (stage))

/* In the order in which they run. Export has no row, it is the run's end. */
extern const pc_stage *const pc_stages[PC_STAGE_EXPORT];
extern const pc_stage pc_stage_scan, pc_stage_mesh, pc_stage_parts, pc_stage_curvature, pc_stage_field,
    pc_stage_curl, pc_stage_param, pc_stage_layout, pc_stage_quads, pc_stage_spline;

/* Asked for by the options, and not after the last stage. */
bool pc_stage_wanted(pc_stage_id stage, const pc_convert_options *options);
/* SHA-256 of the version, the options and the keys of the needs; for the scan also of the input. */
pc_status pc_stage_make_key(pc_run *run, pc_stage_id stage);
/* Sets run->kept, and the record, where the file of the stage is whole and has the right key. */
pc_status pc_stage_look(pc_run *run, pc_stage_id stage);
/* Opens the file of a finished stage. */
pc_status pc_stage_open(pc_store **store, pc_run *run, pc_stage_id stage);
/* Brings the product into memory where it is not. */
pc_status pc_stage_hold(pc_run *run, pc_stage_id stage);
void pc_stage_drop(pc_run *run, pc_stage_id stage);
/* Makes, checks and saves the product; its needs are held. */
pc_status pc_stage_make(pc_run *run, pc_stage_id stage);

#endif
