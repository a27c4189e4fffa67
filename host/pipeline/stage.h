/* The stages of a conversion: a static table that the run walks along. A stage is plugged in by one row. */
#ifndef PC_STAGE_H
#define PC_STAGE_H

#include "json.h"
#include "products.h"
#include "run.h"
#include "sha256.h"
#include "store.h"

typedef struct pc_stage_record {
    pc_stage_state state;
    double wall_seconds, cpu_seconds;
    size_t counted_peak;  /* bytes allocated through the context */
    size_t resident_peak; /* bytes of the process */
    char note[160];       /* what the user sees behind the stage */
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
    const char *out;
    char input_sha256[PC_SHA256_TEXT];
    uint64_t input_bytes;
    pc_device *device;
    bool wanted[PC_STAGE_COUNT];
    bool kept[PC_STAGE_COUNT]; /* an earlier run left its file */
    bool held[PC_STAGE_COUNT]; /* the product is in memory */
    char key[PC_STAGE_COUNT][PC_SHA256_TEXT];
    pc_stage_record record[PC_STAGE_COUNT];
    pc_kernel_record *kernels;
    size_t kernel_count;
    pc_products products;
} pc_run;

typedef struct pc_stage {
    const char *name;
    int version;    /* raised whenever equal inputs give other bytes */
    unsigned needs; /* PC_NEEDS(...) of the stages whose products it reads */
    bool optional;  /* runs only where an option asks for it */
    /* The options that its product depends on. */
    void (*options)(pc_json *json, const pc_convert_options *options);
    /* Fills its product, and the note. */
    pc_status (*make)(pc_run *run);
    pc_status (*check)(pc_run *run);
    pc_status (*save)(pc_run *run, pc_store *store);
    pc_status (*load)(pc_run *run, pc_store *store);
    void (*drop)(pc_run *run);
} pc_stage;

#define PC_NEEDS(stage) (1U << (stage))

/* In the order in which they run; export has no row, it is the run's end. */
extern const pc_stage pc_stages[PC_STAGE_EXPORT];

/* True where the options ask for this stage. */
bool pc_stage_wanted(pc_stage_id stage, const pc_convert_options *options);
/* SHA-256 of the version, the options and the keys of the needs; for the scan also of the input. */
pc_status pc_stage_make_key(pc_run *run, pc_stage_id stage);
/* out/stages/<name>.h5; free with pc_free. */
pc_status pc_stage_path(char **path, const pc_run *run, pc_stage_id stage);
/* Sets run->kept where the file of the stage is whole and has the right key. */
pc_status pc_stage_look(pc_run *run, pc_stage_id stage);
/* Brings the product into memory where it is not. */
pc_status pc_stage_hold(pc_run *run, pc_stage_id stage);
void pc_stage_drop(pc_run *run, pc_stage_id stage);
/* Makes, checks and saves the product. */
pc_status pc_stage_make(pc_run *run, pc_stage_id stage);

#endif
