#include "energy.h"
#include "cubic.h"
#include "memory.h"
#include <stdlib.h>
#include <string.h>

/* The integrals of products of Bernstein polynomials over 0..1, and of their first and second derivatives. */
typedef struct plate {
    double product[3][4][4];
} plate;

static void make_plate(plate *p) {
    static const double node[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                   0.8611363115940526};
    static const double weight[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                     0.3478548451374538};
    memset(p, 0, sizeof *p);
    for (int q = 0; q < 4; q++) {
        double b[3][4];
        pc_bernstein(b[0], b[1], b[2], (1 + node[q]) / 2);
        for (int d = 0; d < 3; d++)
            for (int i = 0; i < 16; i++)
                p->product[d][i / 4][i % 4] += weight[q] / 2 * b[d][i / 4] * b[d][i % 4];
    }
}

enum { PACKED = 136 }; /* a symmetric 16 x 16 matrix, rows of its lower half */

/* Of one element, in its Bezier points. */
typedef struct local_energy {
    double matrix[PACKED];
    double right[48];
} local_energy;

static void add_bending(local_energy *to, const pc_tspline *spline, pc_index e, const plate *p,
                        double fairness) {
    const pc_element *element = spline->basis.element + e;
    const double *size = spline->mesh.face[element->face].size;
    double a = (element->high[0] - element->low[0]) / size[0];
    double b = (element->high[1] - element->low[1]) / size[1];
    for (int i = 0, at = 0; i < 16; i++)
        for (int j = 0; j <= i; j++, at++) {
            double s[3], t[3];
            for (int d = 0; d < 3; d++) {
                s[d] = p->product[d][i % 4][j % 4];
                t[d] = p->product[d][i / 4][j / 4];
            }
            to->matrix[at] += fairness * (b / (a * a * a) * s[2] * t[0] + 2 / (a * b) * s[1] * t[1] +
                                          a / (b * b * b) * s[0] * t[2]);
        }
}

static void add_sample(local_energy *to, const pc_element *element, const pc_sample *sample) {
    double s[4], t[4], value[16], unused[8];
    pc_bernstein(s, unused, unused + 4,
                 (sample->place.s - element->low[0]) / (element->high[0] - element->low[0]));
    pc_bernstein(t, unused, unused + 4,
                 (sample->place.t - element->low[1]) / (element->high[1] - element->low[1]));
    for (int i = 0, at = 0; i < 16; i++) {
        value[i] = s[i % 4] * t[i / 4];
        for (int j = 0; j <= i; j++, at++)
            to->matrix[at] += sample->weight * value[i] * value[j];
        to->right[3 * i] += sample->weight * value[i] * sample->target.x;
        to->right[3 * i + 1] += sample->weight * value[i] * sample->target.y;
        to->right[3 * i + 2] += sample->weight * value[i] * sample->target.z;
    }
}

static void multiply_packed(double y[16], const double *matrix, const double x[16]) {
    memset(y, 0, 16 * sizeof *y);
    for (int i = 0, at = 0; i < 16; i++) {
        for (int j = 0; j < i; j++, at++) {
            y[i] += matrix[at] * x[j];
            y[j] += matrix[at] * x[i];
        }
        y[i] += matrix[at++] * x[i];
    }
}

typedef struct assembly {
    const pc_tspline *spline;
    local_energy *local; /* per element */
    size_t *start;       /* per vertex: its uses in `use` */
    size_t *use;         /* places in basis->point */
    pc_index *element;   /* per place in basis->point */
} assembly;

static pc_status find_uses(assembly *a, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_basis *basis = &a->spline->basis;
    size_t points = basis->start[basis->element_count];
    PC_TRY(pc_new(&a->start, ctx, (size_t)basis->vertex_count + 2));
    PC_TRY(pc_new(&a->use, ctx, points));
    PC_TRY(pc_new(&a->element, ctx, points));
    for (size_t k = 0; k < points; k++)
        a->start[basis->point[k] + 2]++;
    for (size_t v = 0; v < basis->vertex_count; v++)
        a->start[v + 2] += a->start[v + 1];
    for (pc_index e = 0; e < basis->element_count; e++)
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            a->use[a->start[basis->point[k] + 1]++] = k;
            a->element[k] = e;
        }
done:
    return status;
}

static int compare(const void *x, const void *y) {
    pc_index a = *(const pc_index *)x, b = *(const pc_index *)y;
    return (a > b) - (a < b);
}

/* The columns of row v, ascending, itself left out. `seen` is scratch, a value per vertex that no row has. */
static size_t columns_of(pc_index *column, pc_index *seen, const assembly *a, pc_index v) {
    const pc_basis *basis = &a->spline->basis;
    size_t count = 0;
    seen[v] = v;
    for (size_t u = a->start[v]; u < a->start[v + 1]; u++) {
        pc_index e = a->element[a->use[u]];
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            pc_index w = basis->point[k];
            if (seen[w] == v) continue;
            seen[w] = v;
            column[count++] = w;
        }
    }
    qsort(column, count, sizeof *column, compare);
    return count;
}

static void fill_row(pc_system *system, double *right, const assembly *a, pc_index v) {
    const pc_basis *basis = &a->spline->basis;
    size_t rows = system->row_count;
    const pc_index *column = system->column + system->start[v];
    size_t count = system->start[v + 1] - system->start[v];
    for (size_t u = a->start[v]; u < a->start[v + 1]; u++) {
        size_t place = a->use[u];
        pc_index e = a->element[place];
        double c[16], y[16];
        pc_basis_coefficients(c, basis, e, place);
        multiply_packed(y, a->local[e].matrix, c);
        for (int i = 0; i < 48; i++)
            right[(size_t)(i % 3) * rows + v] += c[i / 3] * a->local[e].right[i];
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            double d[16], sum = 0;
            pc_basis_coefficients(d, basis, e, k);
            for (int i = 0; i < 16; i++)
                sum += y[i] * d[i];
            if (basis->point[k] == v) {
                system->diagonal[v] += sum;
                continue;
            }
            const pc_index *at = bsearch(basis->point + k, column, count, sizeof *column, compare);
            system->value[system->start[v] + (size_t)(at - column)] += sum;
        }
    }
    if (system->diagonal[v] > 0) return;
    system->diagonal[v] = 1; /* no function of its own on the surface */
    for (size_t k = 0; k < 3; k++)
        right[k * rows + v] = a->spline->position[3 * (size_t)v + k];
}

static pc_status fill_locals(assembly *a, pc_context *ctx, const pc_sample *samples, size_t count,
                             double fairness, const double *stiffness) {
    pc_status status = PC_OK;
    const pc_basis *basis = &a->spline->basis;
    size_t *first = NULL;
    plate p;
    make_plate(&p);
    PC_TRY(pc_new(&a->local, ctx, basis->element_count));
    PC_TRY(pc_new(&first, ctx, (size_t)basis->element_count + 1));
    for (size_t i = 0; i < count; i++)
        first[samples[i].place.element + 1]++;
    for (size_t e = 0; e < basis->element_count; e++)
        first[e + 1] += first[e];
#pragma omp parallel for schedule(static)
    for (pc_index e = 0; e < basis->element_count; e++) {
        add_bending(a->local + e, a->spline, e, &p, stiffness ? stiffness[e] * fairness : fairness);
        for (size_t i = first[e]; i < first[e + 1]; i++)
            add_sample(a->local + e, basis->element + e, samples + i);
    }
done:
    pc_free(ctx, first);
    return status;
}

static pc_status fill_pattern(pc_system *system, pc_context *ctx, const assembly *a) {
    pc_status status = PC_OK;
    pc_index *column = NULL, *seen = NULL, rows = a->spline->basis.vertex_count;
    size_t count = 0, room = 64 * (size_t)rows;
    size_t *start = NULL;
    PC_TRY(pc_new(&seen, ctx, rows));
    PC_TRY(pc_new(&start, ctx, (size_t)rows + 1));
    PC_TRY(pc_new(&column, ctx, room));
    memset(seen, 0xff, rows * sizeof *seen);
    for (pc_index v = 0; v < rows; v++) {
        if (count + rows > room) { /* a row may couple to all others, but hardly ever to a hundred */
            room = 2 * room + rows;
            PC_TRY(pc_resize(&column, ctx, room));
        }
        count += columns_of(column + count, seen, a, v);
        start[v + 1] = count;
    }
    PC_TRY(pc_system_make(system, ctx, PC_BLOCK_SCALAR, rows, count));
    memcpy(system->column, column, count * sizeof *column);
    for (pc_index v = 0; v < rows; v++)
        system->start[v + 1] = (pc_index)start[v + 1];
done:
    pc_free(ctx, column);
    pc_free(ctx, seen);
    pc_free(ctx, start);
    return status;
}

pc_status pc_energy_assemble(pc_system *system, double **right, pc_context *ctx, const pc_tspline *spline,
                             const pc_sample *samples, size_t count, double fairness,
                             const double *stiffness) {
    pc_status status = PC_OK;
    assembly a = {.spline = spline};
    pc_index rows = spline->basis.vertex_count;
    *system = (pc_system){0};
    *right = NULL;
    PC_TRY(find_uses(&a, ctx));
    PC_TRY(fill_locals(&a, ctx, samples, count, fairness, stiffness));
    PC_TRY(fill_pattern(system, ctx, &a));
    PC_TRY(pc_new(right, ctx, 3 * (size_t)rows));
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < rows; v++)
        fill_row(system, *right, &a, v);
done:
    pc_free(ctx, a.local);
    pc_free(ctx, a.start);
    pc_free(ctx, a.use);
    pc_free(ctx, a.element);
    if (status != PC_OK) {
        pc_system_free(system, ctx);
        pc_free(ctx, *right);
        *right = NULL;
    }
    return status;
}
