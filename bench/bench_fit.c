/* One system of a spline fit on tori of ever more control points: seconds of its parts, iterations, memory.
 * bench_fit [DEVICE, default host] [LARGEST, control points, default 100000] [SAMPLES per element, default 9]
 * [SHARE of elements without samples, default 0]
 */
#include "clock.h"
#include "energy.h"
#include "memory.h"
#include "random.h"
#include "synth_quads.h"
#include "threefold.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct bench {
    pc_device *device;
    size_t per_element;
    double bare;
} bench;

/* Samples beside the surface, as far off as a fraction of a face. */
static pc_status make_samples(pc_sample **sample, size_t *count, pc_context *ctx, const pc_tspline *spline,
                              const bench *b) {
    pc_status status = PC_OK;
    const pc_basis *basis = &spline->basis;
    pc_random random = {1};
    *count = 0;
    PC_TRY(pc_new(sample, ctx, b->per_element * basis->element_count));
    for (pc_index e = 0; e < basis->element_count; e++) {
        const pc_element *element = basis->element + e;
        const bool bare = pc_random_uniform(&random) < b->bare;
        for (size_t k = 0; k < b->per_element && !bare; k++) {
            const double u = pc_random_uniform(&random), v = pc_random_uniform(&random);
            pc_sample *to = *sample + (*count)++;
            to->place = (pc_surface_place){e, element->low[0] + u * (element->high[0] - element->low[0]),
                                           element->low[1] + v * (element->high[1] - element->low[1])};
            const pc_surface_point x = pc_tspline_evaluate(spline, to->place);
            to->target = pc_madd(x.p, 0.1 * pc_norm(x.s) * sin(40 * x.p.z), pc_unit(pc_cross(x.s, x.t)));
            to->weight = 1 / (double)b->per_element;
        }
    }
done:
    return status;
}

static pc_status solve(pc_context *ctx, const bench *b, const pc_energy *energy, double *seconds,
                       pc_threefold_stats *solved) {
    pc_status status = PC_OK;
    pc_threefold *solver = NULL;
    double *move = NULL, goal[3], square = 0;
    const double begin = pc_clock_wall(), relative = 1e-4;
    for (size_t i = 0; i < 3 * (size_t)energy->row_count; i++)
        square += energy->right[i] * energy->right[i];
    for (int k = 0; k < 3; k++)
        goal[k] = relative * sqrt(square / 3);
    PC_TRY(pc_new(&move, ctx, 3 * (size_t)energy->row_count));
    PC_TRY(pc_threefold_make(&solver, ctx, b->device, &energy->system));
    PC_TRY(pc_threefold_solve(solver, ctx, solved, move, energy->right, goal, 10000));
    *seconds = pc_clock_wall() - begin;
done:
    pc_threefold_free(solver, ctx);
    pc_free(ctx, move);
    return status;
}

static pc_status measure(pc_context *ctx, const bench *b, pc_index across) {
    pc_status status = PC_OK;
    const pc_tmesh_options making = PC_TMESH_DEFAULTS;
    pc_polymesh quads = {0};
    pc_tspline spline = {0};
    pc_energy energy = {0};
    pc_energy_facts facts;
    pc_sample *sample = NULL;
    double at[3], seconds = 0;
    pc_threefold_stats solved = {0};
    size_t count = 0;
    PC_TRY(pc_synth_quad_torus(&quads, ctx, 2, 1, 2 * across, across));
    PC_TRY(pc_tspline_make(&spline, ctx, &quads, &making));
    PC_TRY(make_samples(&sample, &count, ctx, &spline, b));
    const size_t before = pc_memory_used(ctx);
    pc_memory_reset_peak(ctx);
    at[0] = pc_clock_wall();
    PC_TRY(pc_energy_make(&energy, ctx, &spline, NULL));
    at[1] = pc_clock_wall();
    PC_TRY(pc_energy_fill(&energy, &facts, ctx, b->device, sample, count, 3e-4));
    at[2] = pc_clock_wall();
    PC_TRY(solve(ctx, b, &energy, &seconds, &solved));
    printf("{\"bench\": \"fit\", \"device\": \"%s\", \"points\": %u, \"samples\": %zu, \"couplings\": %u, "
           "\"graph_s\": %.3f, \"values_s\": %.3f, \"solve_s\": %.3f, \"iterations\": %u, "
           "\"spline_mb\": %.0f, \"fit_mb\": %.0f}\n",
           pc_device_name(b->device), energy.row_count, count, energy.system.start[energy.row_count],
           at[1] - at[0], at[2] - at[1], seconds, solved.iterations, (double)before / 1e6,
           (double)(pc_memory_peak(ctx) - before) / 1e6);
done:
    pc_energy_free(&energy, ctx);
    pc_free(ctx, sample);
    pc_tspline_free(&spline, ctx);
    pc_polymesh_free(&quads, ctx);
    return status;
}

int main(int argc, char **argv) {
    pc_context *ctx = pc_context_make();
    bench b = {.per_element = argc > 3 ? strtoul(argv[3], NULL, 10) : 9,
               .bare = argc > 4 ? strtod(argv[4], NULL) : 0};
    const double largest = argc > 2 ? strtod(argv[2], NULL) : 1e5;
    if (!ctx) return pc_status_exit_code(PC_E_NOMEM);
    pc_status status = pc_device_open(&b.device, ctx, argc > 1 ? argv[1] : "host");
    for (pc_index points = 2000; status == PC_OK && points <= largest * 1.01;
         points *= points < 200000 ? 10 : 5)
        status = measure(ctx, &b, (pc_index)lround(sqrt(points / 2.0)));
    if (status != PC_OK) (void)fprintf(stderr, "bench_fit: %s\n", pc_context_message(ctx));
    pc_device_close(b.device, ctx);
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
