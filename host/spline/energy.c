#include "energy.h"
#include "cubic.h"
#include "memory.h"
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* What is known of one element: sums over its samples, u and v from 0 to 1 across it, v' = 1-v. */
enum {
    LOCAL_MOMENT = 0,   /* 49, I + 7J: of weight u^I u'^(6-I) v^J v'^(6-J) */
    LOCAL_PULL = 49,    /* 48: minus half the energy's gradient by the Bezier points, as in pc_tspline */
    LOCAL_BENDING = 97, /* 3: factors of the bending's three terms */
    LOCAL_SIZE = 100
};

static void make_plate(double plate[48]) {
    static const double node[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                   0.8611363115940526};
    static const double weight[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                     0.3478548451374538};
    memset(plate, 0, 48 * sizeof *plate);
    for (int q = 0; q < 4; q++) {
        double b[3][4];
        pc_bernstein(b[0], b[1], b[2], (1 + node[q]) / 2);
        for (int k = 0; k < 48; k++)
            plate[k] += weight[q] / 2 * b[k / 16][k / 4 % 4] * b[k / 16][k % 4];
    }
}

void pc_energy_bending(double factor[3], const pc_energy *energy, pc_index e, double fairness) {
    const pc_tspline *spline = energy->spline;
    const pc_index f = spline->basis.element[e].face;
    double part[2];
    pc_tspline_part(part, spline, e);
    const double a = part[0], b = part[1];
    /* Bending of the unit square falls with the fourth power of a face's size, and would let small faces
     * fold. */
    const double *size = spline->mesh.face[f].size;
    if (energy->stiffness) fairness *= (double)energy->stiffness[f];
    fairness /= sqrt(size[0] * size[1]);
    factor[0] = fairness * b / (a * a * a);
    factor[1] = fairness * 2 / (a * b);
    factor[2] = fairness * a / (b * b * b);
}

/* ---- the graph ---- */

static pc_status list_rows(pc_energy *energy, pc_context *ctx, const uint8_t *free) {
    pc_status status = PC_OK;
    const pc_basis *basis = &energy->spline->basis;
    const size_t points = basis->start[basis->element_count];
    uint8_t *used = NULL;
    PC_TRY(pc_new(&used, ctx, basis->vertex_count));
    PC_TRY(pc_new(&energy->row, ctx, basis->vertex_count));
    PC_TRY(pc_new(&energy->vertex, ctx, basis->vertex_count));
    for (size_t k = 0; k < points; k++)
        used[basis->point[k]] = 1;
    for (pc_index v = 0; v < basis->vertex_count; v++) {
        energy->row[v] = PC_NONE;
        if (!used[v] || (free && !free[v])) continue;
        energy->row[v] = energy->row_count;
        energy->vertex[energy->row_count++] = v;
    }
done:
    pc_free(ctx, used);
    return status;
}

static pc_status list_elements(pc_energy *energy, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &energy->spline->basis;
    PC_TRY(pc_new(&energy->local, ctx, basis->element_count));
    PC_TRY(pc_new(&energy->element, ctx, basis->element_count));
    for (pc_index e = 0; e < basis->element_count; e++) {
        energy->local[e] = PC_NONE;
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++)
            if (energy->row[basis->point[k]] != PC_NONE) {
                energy->local[e] = energy->element_count;
                energy->element[energy->element_count++] = e;
                break;
            }
    }
done:
    return status;
}

/* Which functions on which elements a row is made of, and where its slots start. */
static pc_status list_uses(pc_energy *energy, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &energy->spline->basis;
    const pc_index rows = energy->row_count;
    PC_TRY(pc_new(&energy->start, ctx, (size_t)rows + 2));
    PC_TRY(pc_new(&energy->slot_start, ctx, (size_t)rows + 1));
    for (pc_index i = 0; i < energy->element_count; i++) {
        const pc_index e = energy->element[i];
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            const pc_index r = energy->row[basis->point[k]];
            if (r == PC_NONE) continue;
            energy->start[r + 2]++;
            energy->slot_start[r + 1] += basis->start[e + 1] - basis->start[e];
        }
    }
    for (pc_index r = 0; r < rows; r++) {
        energy->start[r + 2] += energy->start[r + 1];
        energy->slot_start[r + 1] += energy->slot_start[r];
    }
    PC_TRY(pc_new(&energy->use, ctx, energy->start[rows + 1]));
    PC_TRY(pc_new(&energy->use_element, ctx, energy->start[rows + 1]));
    for (pc_index i = 0; i < energy->element_count; i++) {
        const pc_index e = energy->element[i];
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            const pc_index r = energy->row[basis->point[k]];
            if (r == PC_NONE) continue;
            const size_t at = energy->start[r + 1]++;
            energy->use[at] = k;
            energy->use_element[at] = i;
        }
    }
done:
    return status;
}

/* The rows that row r couples to, itself left out, in the order in which they come up. `seen` is scratch, a
 * value per row that no other row has. */
static size_t couplings(pc_index *column, pc_index *seen, const pc_energy *energy, pc_index r) {
    const pc_basis *basis = &energy->spline->basis;
    size_t count = 0;
    seen[r] = r;
    for (size_t u = energy->start[r]; u < energy->start[r + 1]; u++) {
        const pc_index e = energy->element[energy->use_element[u]];
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            const pc_index other = energy->row[basis->point[k]];
            if (other == PC_NONE || seen[other] == r) continue;
            seen[other] = r;
            if (column) column[count] = other;
            count++;
        }
    }
    return count;
}

static int compare(const void *x, const void *y) {
    const pc_index a = *(const pc_index *)x, b = *(const pc_index *)y;
    return (a > b) - (a < b);
}

/* Columns of row r, and where the functions of each use go in it. `place` is scratch, one per row. */
static void link_row(pc_energy *energy, pc_index *seen, pc_index *place, pc_index r) {
    const pc_basis *basis = &energy->spline->basis;
    const pc_system *system = &energy->system;
    pc_index *column = system->column + system->start[r];
    uint16_t *slot = energy->slot + energy->slot_start[r];
    const size_t count = couplings(column, seen, energy, r);
    qsort(column, count, sizeof *column, compare);
    for (size_t k = 0; k < count; k++)
        place[column[k]] = (pc_index)k;
    for (size_t u = energy->start[r]; u < energy->start[r + 1]; u++) {
        const pc_index e = energy->element[energy->use_element[u]];
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            const pc_index other = energy->row[basis->point[k]];
            *slot++ = other == PC_NONE ? PC_SLOT_FIXED
                      : other == r     ? PC_SLOT_DIAGONAL
                                       : (uint16_t)place[other];
        }
    }
}

static pc_status link_rows(pc_energy *energy, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_index rows = energy->row_count;
    const size_t threads = (size_t)omp_get_max_threads();
    pc_index *seen = NULL, *place = NULL;
    size_t *length = NULL, total = 0;
    PC_TRY(pc_new(&seen, ctx, threads * rows));
    PC_TRY(pc_new(&place, ctx, threads * rows));
    PC_TRY(pc_new(&length, ctx, rows));
    memset(seen, 0xff, threads * rows * sizeof *seen);
#pragma omp parallel for schedule(static)
    for (pc_index r = 0; r < rows; r++)
        length[r] = couplings(NULL, seen + (size_t)omp_get_thread_num() * rows, energy, r);
    for (pc_index r = 0; r < rows; r++) {
        total += length[r];
        if (length[r] >= PC_SLOT_DIAGONAL)
            PC_TRY(pc_fail(ctx, PC_E_MESH, "control point %u couples to %zu others", energy->vertex[r],
                           length[r]));
    }
    PC_TRY(pc_system_make(&energy->system, ctx, PC_BLOCK_SCALAR, rows, total));
    for (pc_index r = 0; r < rows; r++)
        energy->system.start[r + 1] = energy->system.start[r] + (pc_index)length[r];
    PC_TRY(pc_new(&energy->slot, ctx, energy->slot_start[rows]));
    memset(seen, 0xff, threads * rows * sizeof *seen);
#pragma omp parallel for schedule(static)
    for (pc_index r = 0; r < rows; r++) {
        const size_t own = (size_t)omp_get_thread_num() * rows;
        link_row(energy, seen + own, place + own, r);
    }
done:
    pc_free(ctx, seen);
    pc_free(ctx, place);
    pc_free(ctx, length);
    return status;
}

pc_status pc_energy_make(pc_energy *energy, pc_context *ctx, const pc_tspline *spline, const uint8_t *free) {
    pc_status status = PC_OK;
    *energy = (pc_energy){.spline = spline};
    make_plate(energy->plate);
    PC_TRY(list_rows(energy, ctx, free));
    PC_TRY(list_elements(energy, ctx));
    PC_TRY(list_uses(energy, ctx));
    PC_TRY(link_rows(energy, ctx));
    PC_TRY(pc_new(&energy->right, ctx, 3 * (size_t)energy->row_count));
    PC_TRY(pc_new(&energy->tally, ctx, 3 * (size_t)energy->element_count));
done:
    if (status != PC_OK) pc_energy_free(energy, ctx);
    return status;
}

void pc_energy_free(pc_energy *energy, pc_context *ctx) {
    pc_energy_withdraw(energy, ctx);
    pc_system_free(&energy->system, ctx);
    pc_free(ctx, energy->vertex);
    pc_free(ctx, energy->row);
    pc_free(ctx, energy->element);
    pc_free(ctx, energy->local);
    pc_free(ctx, energy->start);
    pc_free(ctx, energy->use);
    pc_free(ctx, energy->use_element);
    pc_free(ctx, energy->slot_start);
    pc_free(ctx, energy->slot);
    pc_free(ctx, energy->right);
    pc_free(ctx, energy->tally);
    *energy = (pc_energy){0};
}

/* ---- local sums ---- */

/* b[i] = u^i (1-u)^(n-i) */
static void powers(double *b, int n, double u) {
    double up = 1, down = 1;
    for (int i = 0; i <= n; i++) {
        b[i] = up;
        up *= u;
    }
    for (int i = n; i >= 0; i--) {
        b[i] *= down;
        down *= 1 - u;
    }
}

static void add_pull(double *local, double *tally, const double *bezier, double u, double v,
                     const pc_sample *sample) {
    double s[4], t[4], value[16], r[3] = {sample->target.x, sample->target.y, sample->target.z};
    powers(s, 3, u), powers(t, 3, v);
    s[1] *= 3, s[2] *= 3, t[1] *= 3, t[2] *= 3;
    for (int i = 0; i < 16; i++) {
        value[i] = s[i % 4] * t[i / 4];
        for (int k = 0; k < 3; k++)
            r[k] -= value[i] * bezier[3 * i + k];
    }
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < 3; k++)
            local[LOCAL_PULL + 3 * i + k] += sample->weight * value[i] * r[k];
    tally[0] += sample->weight * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    tally[1] += sample->weight;
}

static void add_moments(double *moment, double u, double v, double weight) {
    double s[7], t[7];
    powers(s, 6, u), powers(t, 6, v);
    for (int j = 0; j < 7; j++)
        for (int i = 0; i < 7; i++)
            moment[i + 7 * j] += weight * t[j] * s[i];
}

/* y += the bending's matrix times the 16 numbers c. */
static void add_bending(double y[16], const double *factor, const double *plate, const double c[16]) {
    for (int d = 0; d < 3; d++) {
        const double *along = plate + 16 * (2 - d), *across = plate + 16 * d;
        double z[16] = {0};
        for (int l = 0; l < 4; l++)
            for (int k = 0; k < 4; k++)
                for (int i = 0; i < 4; i++)
                    z[i + 4 * l] += factor[d] * along[i + 4 * k] * c[k + 4 * l];
        for (int j = 0; j < 4; j++)
            for (int l = 0; l < 4; l++)
                for (int i = 0; i < 4; i++)
                    y[i + 4 * j] += across[j + 4 * l] * z[i + 4 * l];
    }
}

static void fill_local(double *local, double *tally, const pc_energy *energy, pc_index e,
                       const pc_energy_work *work) {
    const pc_element *element = energy->spline->basis.element + e;
    const double *bezier = energy->spline->bezier + 48 * (size_t)e;
    memset(local, 0, LOCAL_SIZE * sizeof *local);
    memset(tally, 0, 3 * sizeof *tally);
    for (size_t i = work->first[e]; i < work->first[e + 1]; i++) {
        const pc_sample *sample = work->samples + i;
        const double u = (sample->place.s - element->low[0]) / (element->high[0] - element->low[0]);
        const double v = (sample->place.t - element->low[1]) / (element->high[1] - element->low[1]);
        add_pull(local, tally, bezier, u, v, sample);
        add_moments(local + LOCAL_MOMENT, u, v, sample->weight);
    }
    pc_energy_bending(local + LOCAL_BENDING, energy, e, work->fairness);
    for (int k = 0; k < 3; k++) {
        double x[16], y[16] = {0};
        for (int i = 0; i < 16; i++)
            x[i] = bezier[3 * i + k];
        add_bending(y, local + LOCAL_BENDING, energy->plate, x);
        for (int i = 0; i < 16; i++) {
            local[LOCAL_PULL + 3 * i + k] -= y[i];
            tally[2] += x[i] * y[i];
        }
    }
}

/* ---- rows ---- */

static const double binomial[4] = {1, 3, 3, 1};

/* y = the element's matrix times c, both in Bezier coefficients. */
static void apply_local(double y[16], const double *local, const double *plate, const double c[16]) {
    memset(y, 0, 16 * sizeof *y);
    for (int l = 0; l < 4; l++)
        for (int k = 0; k < 4; k++) {
            const double factor = binomial[k] * binomial[l] * c[k + 4 * l];
            for (int j = 0; j < 4; j++)
                for (int i = 0; i < 4; i++)
                    y[i + 4 * j] += factor * local[LOCAL_MOMENT + i + k + 7 * (j + l)];
        }
    for (int i = 0; i < 16; i++)
        y[i] *= binomial[i % 4] * binomial[i / 4];
    add_bending(y, local + LOCAL_BENDING, plate, c);
}

/* The same for c[i+4j] = a[i] b[j]. */
static void apply_product(double y[16], const double *local, const double *plate, const double a[4],
                          const double b[4]) {
    const double *moment = local + LOCAL_MOMENT, *factor = local + LOCAL_BENDING;
    double half[28] = {0}, along[12] = {0}, across[12] = {0};
    memset(y, 0, 16 * sizeof *y);
    for (int j = 0; j < 7; j++)
        for (int k = 0; k < 4; k++)
            for (int i = 0; i < 4; i++)
                half[i + 4 * j] += binomial[k] * a[k] * moment[i + k + 7 * j];
    for (int j = 0; j < 4; j++)
        for (int l = 0; l < 4; l++)
            for (int i = 0; i < 4; i++)
                y[i + 4 * j] += binomial[l] * b[l] * half[i + 4 * (j + l)];
    for (int i = 0; i < 16; i++)
        y[i] *= binomial[i % 4] * binomial[i / 4];
    for (int d = 0; d < 3; d++)
        for (int k = 0; k < 4; k++)
            for (int i = 0; i < 4; i++) {
                along[4 * d + i] += factor[d] * plate[16 * (2 - d) + i + 4 * k] * a[k];
                across[4 * d + i] += plate[16 * d + i + 4 * k] * b[k];
            }
    for (int d = 0; d < 3; d++)
        for (int i = 0; i < 16; i++)
            y[i] += along[4 * d + i % 4] * across[4 * d + i / 4];
}

/* y.(function k on element e) */
static double product(const double y[16], const pc_basis *basis, pc_index e, size_t k) {
    const pc_element *element = basis->element + e;
    const double *from = basis->coefficient + element->coefficient;
    double sum = 0;
    if (element->irregular) {
        from += 16 * k;
        for (int i = 0; i < 16; i++)
            sum += y[i] * from[i];
        return sum;
    }
    from += 8 * k;
    for (int j = 0; j < 4; j++)
        sum += from[4 + j] * (from[0] * y[4 * j] + from[1] * y[4 * j + 1] + from[2] * y[4 * j + 2] +
                              from[3] * y[4 * j + 3]);
    return sum;
}

/* The products of one function with all on its element, into the slots of its row. */
static void add_products(double *value, double *diagonal, const pc_energy *energy, const double *local,
                         const uint16_t *slot, size_t use, pc_index e) {
    const pc_basis *basis = &energy->spline->basis;
    const pc_element *element = basis->element + e;
    const size_t own = use - basis->start[e], functions = basis->start[e + 1] - basis->start[e];
    const double *c = basis->coefficient + element->coefficient;
    double y[16];
    if (element->irregular)
        apply_local(y, local, energy->plate, c + 16 * own);
    else
        apply_product(y, local, energy->plate, c + 8 * own, c + 8 * own + 4);
    for (size_t k = 0; k < functions; k++) {
        if (slot[k] == PC_SLOT_FIXED) continue;
        const double sum = product(y, basis, e, k);
        if (slot[k] == PC_SLOT_DIAGONAL)
            *diagonal += sum;
        else
            value[slot[k]] += sum;
    }
}

static void fill_row(pc_energy *energy, const double *local_sums, pc_index r) {
    const pc_basis *basis = &energy->spline->basis;
    const pc_system *system = &energy->system;
    const uint16_t *slot = energy->slot + energy->slot_start[r];
    double *value = system->value + system->start[r], *right = energy->right + 3 * (size_t)r, diagonal = 0;
    memset(right, 0, 3 * sizeof *right);
    memset(value, 0, (system->start[r + 1] - system->start[r]) * sizeof *value);
    for (size_t u = energy->start[r]; u < energy->start[r + 1]; u++) {
        const pc_index i = energy->use_element[u], e = energy->element[i];
        const double *local = local_sums + LOCAL_SIZE * (size_t)i;
        double c[16];
        pc_basis_coefficients(c, basis, e, energy->use[u]);
        for (int k = 0; k < 16; k++)
            for (int d = 0; d < 3; d++)
                right[d] += c[k] * local[LOCAL_PULL + 3 * k + d];
        add_products(value, &diagonal, energy, local, slot, energy->use[u], e);
        slot += basis->start[e + 1] - basis->start[e];
    }
    system->diagonal[r] = diagonal > 0 ? diagonal : 1;
}

static pc_status fill_on_host(pc_energy *energy, pc_context *ctx, const pc_energy_work *work) {
    double *local = NULL;
    pc_status status = pc_new(&local, ctx, LOCAL_SIZE * (size_t)energy->element_count);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index i = 0; i < energy->element_count; i++)
        fill_local(local + LOCAL_SIZE * (size_t)i, energy->tally + 3 * (size_t)i, energy, energy->element[i],
                   work);
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index r = 0; r < energy->row_count; r++)
        fill_row(energy, local, r);
    pc_free(ctx, local);
    return status;
}

pc_status pc_energy_fill(pc_energy *energy, pc_energy_facts *facts, pc_context *ctx, pc_device *device,
                         const pc_sample *samples, size_t count, double fairness) {
    pc_status status = PC_OK;
    const pc_index elements = energy->spline->basis.element_count;
    size_t *first = NULL;
    *facts = (pc_energy_facts){0};
    PC_TRY(pc_new(&first, ctx, (size_t)elements + 1));
    for (size_t i = 0; i < count; i++)
        first[samples[i].place.element + 1]++;
    for (size_t e = 0; e < elements; e++)
        first[e + 1] += first[e];
    const pc_energy_work work = {samples, first, fairness};
    PC_TRY(pc_device_is_host(device) ? fill_on_host(energy, ctx, &work)
                                     : pc_energy_launch(energy, ctx, device, &work));
    for (pc_index i = 0; i < energy->element_count; i++) {
        facts->square += energy->tally[3 * (size_t)i];
        facts->weight += energy->tally[3 * (size_t)i + 1];
        facts->bending += energy->tally[3 * (size_t)i + 2];
    }
done:
    pc_free(ctx, first);
    return status;
}
