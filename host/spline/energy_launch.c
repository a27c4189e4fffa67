#include "energy.h"
#include "launch.h"
#include "memory.h"
#include <string.h>

extern const char pc_kernel_fit[];

/* Doubles of a sample and of an element's sums, and the mark of irregular elements, as in fit.cl. */
enum { SAMPLE = 6, LOCAL = 97 };
static const uint32_t irregular_mark = 0x80000000u;

/* Rows [from,to) and the elements that they need, so few that every array fits the device's buffers. */
typedef struct part {
    pc_index from, to;
    size_t cap; /* bytes of one array */
    pc_index element_count;
    pc_index *element; /* places in the energy's list, ascending */
    size_t coefficient_count;
    uint32_t *local; /* per element of the energy's list: place in `element`; PC_NONE */
} part;

static size_t coefficients_of(const pc_basis *basis, pc_index e) {
    return (basis->start[e + 1] - basis->start[e]) * (basis->element[e].irregular ? 16 : 8);
}

static size_t largest(const size_t *bytes, size_t count) {
    size_t most = 0;
    for (size_t k = 0; k < count; k++)
        most = bytes[k] > most ? bytes[k] : most;
    return most;
}

/* The rows from part->from on that fit, one at least; p->local tells the elements by their part's number. */
static void choose_rows(part *p, const pc_energy *energy, const pc_energy_work *work) {
    const pc_basis *basis = &energy->spline->basis;
    size_t sample_count = 0;
    p->element_count = 0, p->coefficient_count = 0;
    memset(p->local, 0xff, energy->element_count * sizeof *p->local);
    for (p->to = p->from; p->to < energy->row_count; p->to++) {
        size_t elements = p->element_count, samples = sample_count, coefficients = p->coefficient_count;
        for (size_t u = energy->start[p->to]; u < energy->start[p->to + 1]; u++) {
            const pc_index i = energy->use_element[u], e = energy->element[i];
            if (p->local[i] != PC_NONE) continue;
            p->local[i] = 0;
            p->element[elements++] = i;
            samples += work->first[e + 1] - work->first[e];
            coefficients += coefficients_of(basis, e);
        }
        const size_t bytes[] = {
            elements * LOCAL * sizeof(double), samples * SAMPLE * sizeof(double),
            coefficients * sizeof(double),
            (energy->slot_start[p->to + 1] - energy->slot_start[p->from]) * sizeof(uint16_t),
            (energy->system.start[p->to + 1] - energy->system.start[p->from]) * sizeof(double)};
        if (p->to > p->from && largest(bytes, sizeof bytes / sizeof *bytes) > p->cap) {
            for (size_t k = p->element_count; k < elements; k++)
                p->local[p->element[k]] = PC_NONE;
            break;
        }
        p->element_count = (pc_index)elements;
        sample_count = samples, p->coefficient_count = coefficients;
    }
    pc_index count = 0;
    for (pc_index i = 0; i < energy->element_count; i++)
        if (p->local[i] != PC_NONE) {
            p->local[i] = count;
            p->element[count++] = i;
        }
}

typedef struct buffers {
    /* the graph, and what bending makes of it */
    pc_buffer *start, *use_start, *use, *use_element, *slot_start, *slot;
    pc_buffer *functions, *coefficient_start, *coefficient;
    pc_buffer *plate, *bending, *stiff, *stiff_diagonal;
    /* of one filling; they stay for the next */
    pc_buffer *first, *sample, *bezier;
    size_t sample_room;
    pc_buffer *local, *tally, *value, *diagonal, *right;
} buffers;

static void free_buffers(buffers *b, pc_context *ctx) {
    pc_buffer *all[] = {b->start,          b->use_start, b->use,       b->use_element,
                        b->slot_start,     b->slot,      b->functions, b->coefficient_start,
                        b->coefficient,    b->plate,     b->bending,   b->stiff,
                        b->stiff_diagonal, b->first,     b->sample,    b->bezier,
                        b->local,          b->tally,     b->value,     b->diagonal,
                        b->right};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        pc_buffer_free(all[k], ctx);
    *b = (buffers){0};
}

/* All rows at once; else nothing stays. */
typedef struct pc_energy_resident {
    part part;
    buffers buffers;
    const pc_device *device;
    double fairness;
} pc_energy_resident;

static pc_status upload_samples(buffers *b, size_t *count, pc_context *ctx, pc_device *device,
                                const pc_energy *energy, const pc_energy_work *work, const part *p) {
    pc_status status = PC_OK;
    const pc_tspline *spline = energy->spline;
    const size_t n = p->element_count;
    uint32_t *first = NULL;
    double *sample = NULL, *bezier = NULL;
    PC_TRY(pc_new(&first, ctx, n + 1));
    for (size_t k = 0; k < n; k++) {
        const pc_index e = energy->element[p->element[k]];
        first[k + 1] = first[k] + (uint32_t)(work->first[e + 1] - work->first[e]);
    }
    *count = first[n];
    PC_TRY(pc_buffer_write(b->first, ctx, 0, first, (n + 1) * sizeof *first));
    if (!b->sample || *count > b->sample_room) {
        const size_t slack = *count / 16, most = p->cap / (SAMPLE * sizeof *sample);
        pc_buffer_free(b->sample, ctx), b->sample = NULL, b->sample_room = 0;
        const size_t room = *count + slack < most ? *count + slack : *count;
        PC_TRY(pc_buffer_make(&b->sample, ctx, device, SAMPLE * room * sizeof *sample));
        b->sample_room = room;
    }
    PC_TRY(pc_buffer_map(&sample, ctx, b->sample));
    PC_TRY(pc_buffer_map(&bezier, ctx, b->bezier));
#pragma omp parallel for schedule(static)
    for (size_t k = 0; k < n; k++) {
        const pc_index e = energy->element[p->element[k]];
        const pc_element *element = spline->basis.element + e;
        double *to = sample + SAMPLE * (size_t)first[k];
        for (size_t i = work->first[e]; i < work->first[e + 1]; i++, to += SAMPLE) {
            const pc_sample *s = work->samples + i;
            to[0] = (s->place.s - element->low[0]) / (element->high[0] - element->low[0]);
            to[1] = (s->place.t - element->low[1]) / (element->high[1] - element->low[1]);
            to[2] = s->target.x, to[3] = s->target.y, to[4] = s->target.z;
            to[5] = s->weight;
        }
        memcpy(bezier + 48 * k, spline->bezier + 48 * (size_t)e, 48 * sizeof *bezier);
    }
done:
    if (sample && pc_buffer_unmap(b->sample, ctx, sample) != PC_OK) status = PC_E_DEVICE;
    if (bezier && pc_buffer_unmap(b->bezier, ctx, bezier) != PC_OK) status = PC_E_DEVICE;
    pc_free(ctx, first);
    return status;
}

static pc_status upload_functions(buffers *b, pc_context *ctx, pc_device *device, const pc_energy *energy,
                                  const part *p) {
    pc_status status = PC_OK;
    const pc_basis *basis = &energy->spline->basis;
    const size_t n = p->element_count;
    uint32_t *functions = NULL, *start = NULL;
    double *coefficient = NULL;
    PC_TRY(pc_new(&functions, ctx, n));
    PC_TRY(pc_new(&start, ctx, n + 1));
    PC_TRY(pc_new(&coefficient, ctx, p->coefficient_count));
    for (size_t k = 0; k < n; k++)
        start[k + 1] = start[k] + (uint32_t)coefficients_of(basis, energy->element[p->element[k]]);
#pragma omp parallel for schedule(static)
    for (size_t k = 0; k < n; k++) {
        const pc_index e = energy->element[p->element[k]];
        const pc_element *element = basis->element + e;
        functions[k] = (uint32_t)(basis->start[e + 1] - basis->start[e]);
        if (element->irregular) functions[k] |= irregular_mark;
        memcpy(coefficient + start[k], basis->coefficient + element->coefficient,
               (start[k + 1] - start[k]) * sizeof *coefficient);
    }
    PC_TRY(pc_buffer_from(&b->functions, ctx, device, functions, n * sizeof *functions));
    PC_TRY(pc_buffer_from(&b->coefficient_start, ctx, device, start, n * sizeof *start));
    PC_TRY(pc_buffer_from(&b->coefficient, ctx, device, coefficient,
                          p->coefficient_count * sizeof *coefficient));
done:
    pc_free(ctx, functions);
    pc_free(ctx, start);
    pc_free(ctx, coefficient);
    return status;
}

static pc_status upload_rows(buffers *b, pc_context *ctx, pc_device *device, const pc_energy *energy,
                             const part *p) {
    pc_status status = PC_OK;
    const size_t rows = p->to - p->from, first_use = energy->start[p->from];
    const size_t uses = energy->start[p->to] - first_use, first_slot = energy->slot_start[p->from];
    const pc_index first_value = energy->system.start[p->from];
    uint32_t *start[3] = {NULL, NULL, NULL}, *use = NULL, *use_element = NULL;
    pc_buffer **to[3] = {&b->start, &b->use_start, &b->slot_start};
    for (int k = 0; k < 3; k++)
        PC_TRY(pc_new(&start[k], ctx, rows + 1));
    PC_TRY(pc_new(&use, ctx, uses));
    PC_TRY(pc_new(&use_element, ctx, uses));
    for (size_t r = 0; r <= rows; r++) {
        start[0][r] = energy->system.start[p->from + r] - first_value;
        start[1][r] = (uint32_t)(energy->start[p->from + r] - first_use);
        start[2][r] = (uint32_t)(energy->slot_start[p->from + r] - first_slot);
    }
    for (size_t u = 0; u < uses; u++) {
        const pc_index i = energy->use_element[first_use + u];
        use[u] = (uint32_t)(energy->use[first_use + u] - energy->spline->basis.start[energy->element[i]]);
        use_element[u] = p->local[i];
    }
    for (int k = 0; k < 3; k++)
        PC_TRY(pc_buffer_from(to[k], ctx, device, start[k], (rows + 1) * sizeof(uint32_t)));
    PC_TRY(pc_buffer_from(&b->use, ctx, device, use, uses * sizeof *use));
    PC_TRY(pc_buffer_from(&b->use_element, ctx, device, use_element, uses * sizeof *use_element));
    PC_TRY(pc_buffer_from(&b->slot, ctx, device, energy->slot + first_slot,
                          (energy->slot_start[p->to] - first_slot) * sizeof *energy->slot));
done:
    for (int k = 0; k < 3; k++)
        pc_free(ctx, start[k]);
    pc_free(ctx, use);
    pc_free(ctx, use_element);
    return status;
}

static pc_status upload_bending(buffers *b, pc_context *ctx, pc_device *device, const pc_energy *energy,
                                const part *p, double fairness) {
    pc_status status = PC_OK;
    const size_t n = p->element_count;
    double *bending = NULL;
    PC_TRY(pc_new(&bending, ctx, 3 * n));
    for (size_t k = 0; k < n; k++)
        pc_energy_bending(bending + 3 * k, energy, energy->element[p->element[k]], fairness);
    PC_TRY(pc_buffer_from(&b->bending, ctx, device, bending, 3 * n * sizeof *bending));
    PC_TRY(pc_buffer_from(&b->plate, ctx, device, energy->plate, sizeof energy->plate));
done:
    pc_free(ctx, bending);
    return status;
}

static uint32_t chunk_of(const pc_device *device) {
    return pc_device_shape(device) == PC_SHAPE_CHUNK ? 16 : 1;
}

/* Room for what the kernels make, and the rows of the bending. */
static pc_status make_rows(buffers *b, pc_context *ctx, pc_device *device, const pc_energy *energy,
                           const part *p) {
    pc_status status = PC_OK;
    pc_kernel *kernel = NULL;
    const uint32_t chunk = chunk_of(device), rows = p->to - p->from;
    const size_t values = energy->system.start[p->to] - energy->system.start[p->from];
    const size_t n = p->element_count;
    pc_buffer **value[] = {&b->value, &b->stiff}, **diagonal[] = {&b->diagonal, &b->stiff_diagonal};
    for (int k = 0; k < 2; k++) {
        PC_TRY(pc_buffer_make(value[k], ctx, device, values * sizeof(double)));
        PC_TRY(pc_buffer_make(diagonal[k], ctx, device, rows * sizeof(double)));
    }
    PC_TRY(pc_buffer_make(&b->right, ctx, device, 3 * rows * sizeof(double)));
    PC_TRY(pc_buffer_make(&b->first, ctx, device, (n + 1) * sizeof(uint32_t)));
    PC_TRY(pc_buffer_make(&b->bezier, ctx, device, 48 * n * sizeof(double)));
    PC_TRY(pc_buffer_make(&b->local, ctx, device, LOCAL * n * sizeof(double)));
    PC_TRY(pc_buffer_make(&b->tally, ctx, device, 3 * n * sizeof(double)));
    PC_TRY(pc_kernel_get(&kernel, ctx, device, pc_kernel_fit, "fit_bending"));
    PC_TRY(pc_kernel_run(ctx, kernel, (rows + chunk - 1) / chunk, pc_chunk_group(device),
                         8.0 * ((double)p->coefficient_count + (double)values),
                         PC_ARGS(PC_BUF(b->stiff), PC_BUF(b->stiff_diagonal), PC_BUF(b->start),
                                 PC_BUF(b->use_start), PC_BUF(b->use), PC_BUF(b->use_element),
                                 PC_BUF(b->slot_start), PC_BUF(b->slot), PC_BUF(b->functions),
                                 PC_BUF(b->coefficient_start), PC_BUF(b->coefficient), PC_BUF(b->bending),
                                 PC_BUF(b->plate), PC_U32(rows), PC_U32(chunk))));
done:
    return status;
}

static pc_status run(buffers *b, pc_context *ctx, pc_device *device, const part *p, size_t samples) {
    pc_status status = PC_OK;
    pc_kernel *local = NULL, *row = NULL;
    const uint32_t chunk = chunk_of(device), rows = p->to - p->from;
    const size_t group = pc_chunk_group(device);
    PC_TRY(pc_kernel_get(&local, ctx, device, pc_kernel_fit, "fit_local"));
    PC_TRY(pc_kernel_get(&row, ctx, device, pc_kernel_fit, "fit_rows"));
    PC_TRY(pc_kernel_run(ctx, local, (p->element_count + chunk - 1) / chunk, group,
                         8.0 * (SAMPLE * (double)samples + (48.0 + LOCAL) * p->element_count),
                         PC_ARGS(PC_BUF(b->local), PC_BUF(b->tally), PC_BUF(b->first), PC_BUF(b->sample),
                                 PC_BUF(b->bezier), PC_BUF(b->bending), PC_BUF(b->plate),
                                 PC_U32(p->element_count), PC_U32(chunk))));
    PC_TRY(
        pc_kernel_run(ctx, row, (rows + chunk - 1) / chunk, group,
                      8.0 * ((double)p->coefficient_count + LOCAL * (double)p->element_count),
                      PC_ARGS(PC_BUF(b->value), PC_BUF(b->diagonal), PC_BUF(b->right), PC_BUF(b->stiff),
                              PC_BUF(b->stiff_diagonal), PC_BUF(b->start), PC_BUF(b->use_start),
                              PC_BUF(b->use), PC_BUF(b->use_element), PC_BUF(b->slot_start), PC_BUF(b->slot),
                              PC_BUF(b->functions), PC_BUF(b->coefficient_start), PC_BUF(b->coefficient),
                              PC_BUF(b->first), PC_BUF(b->local), PC_U32(rows), PC_U32(chunk))));
done:
    return status;
}

static pc_status fetch(pc_energy *energy, pc_context *ctx, const buffers *b, const part *p) {
    pc_status status = PC_OK;
    const size_t rows = p->to - p->from, n = p->element_count;
    const pc_system *system = &energy->system;
    double *tally = NULL;
    PC_TRY(pc_new(&tally, ctx, 3 * n));
    PC_TRY(pc_buffer_read(system->value + system->start[p->from], ctx, b->value, 0,
                          (system->start[p->to] - system->start[p->from]) * sizeof(double)));
    PC_TRY(pc_buffer_read(system->diagonal + p->from, ctx, b->diagonal, 0, rows * sizeof(double)));
    PC_TRY(pc_buffer_read(energy->right + 3 * (size_t)p->from, ctx, b->right, 0, 3 * rows * sizeof(double)));
    PC_TRY(pc_buffer_read(tally, ctx, b->tally, 0, 3 * n * sizeof *tally));
    for (size_t k = 0; k < n; k++)
        memcpy(energy->tally + 3 * (size_t)p->element[k], tally + 3 * k, 3 * sizeof *tally);
done:
    pc_free(ctx, tally);
    return status;
}

/* Samples of the elements of a part. */
static size_t samples_of(const pc_energy *energy, const pc_energy_work *work, const part *p) {
    size_t count = 0;
    for (size_t k = 0; k < p->element_count; k++) {
        const pc_index e = energy->element[p->element[k]];
        count += work->first[e + 1] - work->first[e];
    }
    return count;
}

static pc_status fill_part(pc_energy *energy, pc_context *ctx, pc_device *device, const pc_energy_work *work,
                           const part *p, buffers *b) {
    pc_status status = PC_OK;
    size_t samples = 0;
    PC_TRY(upload_samples(b, &samples, ctx, device, energy, work, p));
    PC_TRY(run(b, ctx, device, p, samples));
    PC_TRY(fetch(energy, ctx, b, p));
done:
    return status;
}

static pc_status launch_parts(pc_energy *energy, pc_context *ctx, pc_device *device,
                              const pc_energy_work *work, pc_energy_resident *state) {
    pc_status status = PC_OK;
    part *p = &state->part;
    buffers *b = &state->buffers;
    PC_TRY(pc_new(&p->element, ctx, energy->element_count));
    PC_TRY(pc_new(&p->local, ctx, energy->element_count));
    for (p->from = 0; p->from < energy->row_count; p->from = p->to) {
        free_buffers(b, ctx);
        choose_rows(p, energy, work);
        PC_TRY(upload_functions(b, ctx, device, energy, p));
        PC_TRY(upload_rows(b, ctx, device, energy, p));
        PC_TRY(upload_bending(b, ctx, device, energy, p, work->fairness));
        PC_TRY(make_rows(b, ctx, device, energy, p));
        PC_TRY(fill_part(energy, ctx, device, work, p, b));
        if (p->from == 0 && p->to == energy->row_count) break; /* it stays */
    }
done:
    return status;
}

pc_status pc_energy_launch(pc_energy *energy, pc_context *ctx, pc_device *device,
                           const pc_energy_work *work) {
    const size_t most = (size_t)1 << 30; /* large single buffers are what drivers get wrong */
    pc_status status = PC_OK;
    const size_t cap = pc_device_allocation_cap(device) < most ? pc_device_allocation_cap(device) : most;
    pc_energy_resident *resident = energy->resident;
    PC_TRY(pc_device_require_doubles(device, ctx, "the fit of a surface"));
    if (!energy->row_count) return PC_OK;
    if (resident && resident->device == device && resident->fairness == work->fairness &&
        samples_of(energy, work, &resident->part) * SAMPLE * sizeof(double) <= cap)
        return fill_part(energy, ctx, device, work, &resident->part, &resident->buffers);
    pc_energy_withdraw(energy, ctx);
    PC_TRY(pc_new(&energy->resident, ctx, 1));
    energy->resident->device = device, energy->resident->fairness = work->fairness;
    energy->resident->part.cap = cap;
    PC_TRY(launch_parts(energy, ctx, device, work, energy->resident));
done:
    if (energy->resident && (status != PC_OK || energy->resident->part.from > 0))
        pc_energy_withdraw(energy, ctx);
    return status;
}

void pc_energy_withdraw(pc_energy *energy, pc_context *ctx) {
    if (!energy->resident) return;
    free_buffers(&energy->resident->buffers, ctx);
    pc_free(ctx, energy->resident->part.element);
    pc_free(ctx, energy->resident->part.local);
    pc_free(ctx, energy->resident);
    energy->resident = NULL;
}
