#include "basis.h"
#include "cubic.h"
#include "growing.h"
#include "memory.h"
#include "nurcc.h"
#include "support.h"
#include <math.h>
#include <string.h>

enum { PARTS = 16 }; /* of the mesh, made at the same time */

/* Of `count` things part p has those from first_of(count, p) to first_of(count, p + 1). */
static pc_index first_of(pc_index count, int part) {
    return (pc_index)((uint64_t)count * (uint64_t)part / PARTS);
}

typedef struct function {
    const pc_footprint *footprint;
} function;

/* Which functions there are on each face: in the order of their vertices. */
typedef struct face_functions {
    pc_footprints part[PARTS];
    size_t *start; /* per face: into `at` */
    function *at;
} face_functions;

/* A part of the basis. */
typedef struct building {
    pc_basis basis;
    const pc_tmesh *mesh;
    const face_functions *functions;
    size_t element_room, point_room, coefficient_room, point_count, coefficient_count;
} building;

static void free_functions(face_functions *functions, pc_context *ctx) {
    for (int part = 0; part < PARTS; part++)
        pc_footprints_free(functions->part + part, ctx);
    pc_free(ctx, functions->start);
    pc_free(ctx, functions->at);
}

static pc_status collect_part(pc_footprints *footprints, pc_context *ctx, const pc_tmesh *mesh, pc_index from,
                              pc_index to) {
    pc_status status = PC_OK;
    pc_support scratch = {0};
    for (pc_index v = from; v < to; v++)
        PC_TRY(pc_support_append(footprints, &scratch, ctx, mesh, v));
done:
    pc_support_free(&scratch, ctx);
    return status;
}

static pc_status collect(face_functions *functions, pc_context *ctx, const pc_tmesh *mesh) {
    pc_status status = PC_OK, done[PARTS];
    const size_t faces = mesh->face_count;
    size_t count = 0;
#pragma omp parallel for schedule(dynamic, 1)
    for (int part = 0; part < PARTS; part++)
        done[part] = collect_part(functions->part + part, ctx, mesh, first_of(mesh->vertex_count, part),
                                  first_of(mesh->vertex_count, part + 1));
    for (int part = 0; part < PARTS; part++) {
        PC_TRY(done[part]);
        count += functions->part[part].count;
    }
    PC_TRY(pc_new(&functions->start, ctx, faces + 2));
    PC_TRY(pc_new(&functions->at, ctx, count));
    for (int part = 0; part < PARTS; part++)
        for (size_t i = 0; i < functions->part[part].count; i++)
            functions->start[functions->part[part].at[i].face + 2]++;
    for (size_t f = 0; f < faces; f++)
        functions->start[f + 2] += functions->start[f + 1];
    for (int part = 0; part < PARTS; part++)
        for (size_t i = 0; i < functions->part[part].count; i++) {
            const pc_footprint *p = functions->part[part].at + i;
            functions->at[functions->start[p->face + 1]++].footprint = p;
        }
done:
    return status;
}

static pc_status add_element(building *b, pc_context *ctx, const pc_element *element) {
    pc_status status = PC_OK;
    pc_basis *basis = &b->basis;
    if (basis->element_count + 1 >= b->element_room) { /* one more offset than elements */
        size_t room = 2 * b->element_room + 64;
        PC_TRY(pc_resize(&basis->element, ctx, room));
        PC_TRY(pc_resize(&basis->start, ctx, room + 1));
        b->element_room = room;
    }
    basis->element[basis->element_count] = *element;
    basis->element[basis->element_count].coefficient = b->coefficient_count;
    basis->start[basis->element_count++] = b->point_count;
done:
    return status;
}

static pc_status add_point(building *b, pc_context *ctx, pc_index v, const double *coefficient, size_t stride,
                           size_t count) {
    pc_status status = PC_OK;
    PC_GROW(b->basis.point, b->point_count, b->point_room, 1);
    PC_GROW(b->basis.coefficient, b->coefficient_count, b->coefficient_room, count);
    b->basis.point[b->point_count++] = v;
    for (size_t i = 0; i < count; i++)
        b->basis.coefficient[b->coefficient_count++] = coefficient[i * stride];
done:
    return status;
}

/* The knots of all functions on face f strictly between its sides, sorted, with both sides. On a suitable
 * mesh there are a few; 0 where there are more than MOST_LINES. */
enum { MOST_LINES = 64 };

static int lines_of(double line[MOST_LINES], const building *b, pc_index f, int direction) {
    double size = b->mesh->face[f].size[direction];
    int count = 2;
    line[0] = 0, line[1] = size;
    for (size_t i = b->functions->start[f]; i < b->functions->start[f + 1]; i++) {
        const pc_footprint *p = b->functions->at[i].footprint;
        for (int k = 0; k < 5; k++) {
            double x = direction ? p->t[k] : p->s[k];
            int at = 0;
            if (x <= 0 || x >= size) continue;
            while (at + 1 < count && line[at] < x)
                at++;
            if (line[at] == x) continue;
            if (count == MOST_LINES) return 0;
            memmove(line + at + 1, line + at, (size_t)(count - at) * sizeof *line);
            line[at] = x;
            count++;
        }
    }
    return count;
}

static pc_status cut_regular(building *b, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    double s[MOST_LINES], t[MOST_LINES];
    int columns = lines_of(s, b, f, 0) - 1, rows = lines_of(t, b, f, 1) - 1;
    if (columns < 1 || rows < 1)
        return pc_fail(ctx, PC_E_BUG, "face %u of the T-mesh has more than %d lines", f, MOST_LINES);
    for (int i = 0; i < columns * rows; i++) {
        pc_element element = {.face = f,
                              .low = {s[i % columns], t[i / columns]},
                              .high = {s[i % columns + 1], t[i / columns + 1]}};
        PC_TRY(add_element(b, ctx, &element));
        for (size_t k = b->functions->start[f]; k < b->functions->start[f + 1]; k++) {
            const pc_footprint *p = b->functions->at[k].footprint;
            double c[8];
            if (p->s[0] >= element.high[0] || p->s[4] <= element.low[0] || p->t[0] >= element.high[1] ||
                p->t[4] <= element.low[1])
                continue;
            pc_cubic_bezier(c, p->s, element.low[0], element.high[0]);
            pc_cubic_bezier(c + 4, p->t, element.low[1], element.high[1]);
            PC_TRY(add_point(b, ctx, p->vertex, c, 1, 8));
        }
    }
done:
    return status;
}

static pc_status cut_irregular(building *b, pc_context *ctx, pc_index f) {
    pc_status status = PC_OK;
    pc_patches patches;
    PC_TRY(pc_nurcc_make(&patches, ctx, b->mesh, f));
    for (pc_index i = 0; i < patches.patch_count; i++) {
        const pc_patch *p = patches.patch + i;
        pc_element element = {
            .face = f, .irregular = true, .low = {p->low[0], p->low[1]}, .high = {p->high[0], p->high[1]}};
        PC_TRY(add_element(b, ctx, &element));
        for (pc_index k = 0; k < patches.point_count; k++) {
            double most = 0;
            for (size_t j = 0; j < 16; j++)
                most = fmax(most, fabs(p->weight[j * patches.point_count + k]));
            if (most > 0) PC_TRY(add_point(b, ctx, patches.point[k], p->weight + k, patches.point_count, 16));
        }
    }
done:
    pc_nurcc_free(&patches, ctx);
    return status;
}

static pc_status cut_part(building *b, pc_context *ctx, pc_index *face_start, pc_index from, pc_index to) {
    pc_status status = PC_OK;
    for (pc_index f = from; f < to; f++) {
        if (!b->mesh->face[f].ghost)
            PC_TRY(pc_tface_is_irregular(b->mesh, f) ? cut_irregular(b, ctx, f) : cut_regular(b, ctx, f));
        face_start[f + 1] = b->basis.element_count;
    }
done:
    return status;
}

/* What a part has, behind what the parts before it have. */
static void put_part(pc_basis *basis, const building *b, const building *before, pc_index from, pc_index to) {
    const pc_index elements = before->basis.element_count;
    for (pc_index f = from; f < to; f++)
        basis->face_start[f + 1] += elements;
    for (pc_index e = 0; e < b->basis.element_count; e++) {
        basis->element[elements + e] = b->basis.element[e];
        basis->element[elements + e].coefficient += before->coefficient_count;
        basis->start[elements + e] = before->point_count + b->basis.start[e];
    }
    if (b->point_count == 0) return;
    memcpy(basis->point + before->point_count, b->basis.point, b->point_count * sizeof *basis->point);
    memcpy(basis->coefficient + before->coefficient_count, b->basis.coefficient,
           b->coefficient_count * sizeof *basis->coefficient);
}

static pc_status join(pc_basis *basis, pc_context *ctx, const building *b) {
    pc_status status = PC_OK;
    building before[PARTS + 1] = {{.mesh = NULL}}; /* their counts */
    for (int part = 0; part < PARTS; part++) {
        building *sum = before + part + 1;
        *sum = before[part];
        sum->basis.element_count += b[part].basis.element_count;
        sum->point_count += b[part].point_count, sum->coefficient_count += b[part].coefficient_count;
    }
    const building *all = before + PARTS;
    basis->element_count = all->basis.element_count;
    PC_TRY(pc_new(&basis->element, ctx, basis->element_count));
    PC_TRY(pc_new(&basis->start, ctx, (size_t)basis->element_count + 1));
    PC_TRY(pc_new(&basis->point, ctx, all->point_count));
    PC_TRY(pc_new(&basis->coefficient, ctx, all->coefficient_count));
#pragma omp parallel for schedule(dynamic, 1)
    for (int part = 0; part < PARTS; part++)
        put_part(basis, b + part, before + part, first_of(basis->face_count, part),
                 first_of(basis->face_count, part + 1));
    basis->start[basis->element_count] = all->point_count;
done:
    return status;
}

pc_status pc_basis_make(pc_basis *basis, pc_context *ctx, const pc_tmesh *mesh) {
    pc_status status = PC_OK, done[PARTS];
    face_functions functions = {.start = NULL};
    building b[PARTS];
    *basis = (pc_basis){.vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    for (int part = 0; part < PARTS; part++)
        b[part] = (building){.mesh = mesh, .functions = &functions};
    PC_TRY(collect(&functions, ctx, mesh));
    PC_TRY(pc_new(&basis->face_start, ctx, (size_t)mesh->face_count + 1));
#pragma omp parallel for schedule(dynamic, 1)
    for (int part = 0; part < PARTS; part++)
        done[part] = cut_part(b + part, ctx, basis->face_start, first_of(mesh->face_count, part),
                              first_of(mesh->face_count, part + 1));
    for (int part = 0; part < PARTS; part++)
        PC_TRY(done[part]);
    PC_TRY(join(basis, ctx, b));
done:
    free_functions(&functions, ctx);
    for (int part = 0; part < PARTS; part++)
        pc_basis_free(&b[part].basis, ctx);
    if (status != PC_OK) pc_basis_free(basis, ctx);
    return status;
}

void pc_basis_free(pc_basis *basis, pc_context *ctx) {
    pc_free(ctx, basis->face_start);
    pc_free(ctx, basis->element);
    pc_free(ctx, basis->start);
    pc_free(ctx, basis->point);
    pc_free(ctx, basis->coefficient);
    *basis = (pc_basis){0};
}

void pc_basis_coefficients(double c[16], const pc_basis *basis, pc_index e, size_t k) {
    const pc_element *element = basis->element + e;
    const double *from = basis->coefficient + element->coefficient;
    k -= basis->start[e];
    if (element->irregular) {
        memcpy(c, from + 16 * k, 16 * sizeof(double));
        return;
    }
    for (int i = 0; i < 16; i++)
        c[i] = from[8 * k + (size_t)(i % 4)] * from[8 * k + 4 + (size_t)(i / 4)];
}

void pc_basis_bezier(double bezier[48], const pc_basis *basis, pc_index e, const double *position) {
    memset(bezier, 0, 48 * sizeof(double));
    for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
        const double *p = position + 3 * (size_t)basis->point[k];
        double c[16];
        pc_basis_coefficients(c, basis, e, k);
        for (int i = 0; i < 48; i++)
            bezier[i] += c[i / 3] * p[i % 3];
    }
}

static double outside(double x, double low, double high) {
    return x < low ? low - x : x > high ? x - high : 0;
}

pc_index pc_basis_find(const pc_basis *basis, pc_index face, double s, double t) {
    const pc_index first = basis->face_start[face], end = basis->face_start[face + 1];
    pc_index best = PC_NONE;
    double least = INFINITY;
    if (end == first + 1) return first;
    for (pc_index e = first; e < end; e++) {
        const pc_element *element = basis->element + e;
        const double off =
            outside(s, element->low[0], element->high[0]) + outside(t, element->low[1], element->high[1]);
        if (off < least) least = off, best = e;
    }
    return best;
}

/* Gaussian elimination with full pivoting of `rows` x `columns` coefficients, columns the functions; the
 * smallest pivot relative to the largest. */
static double relative_rank(double *a, size_t rows, size_t columns) {
    double largest = 0, pivot = 0;
    for (size_t step = 0; step < columns; step++) {
        size_t row = step, column = step;
        pivot = 0;
        for (size_t i = step; i < rows; i++)
            for (size_t j = step; j < columns; j++)
                if (fabs(a[i * columns + j]) > pivot) pivot = fabs(a[i * columns + j]), row = i, column = j;
        if (step == 0) largest = pivot;
        if (!(pivot > 0)) return 0;
        for (size_t j = 0; j < columns; j++) {
            double swapped = a[step * columns + j];
            a[step * columns + j] = a[row * columns + j];
            a[row * columns + j] = swapped;
        }
        for (size_t i = 0; i < rows; i++) {
            double swapped = a[i * columns + step];
            a[i * columns + step] = a[i * columns + column];
            a[i * columns + column] = swapped;
        }
        for (size_t i = step + 1; i < rows; i++) {
            double factor = a[i * columns + step] / a[step * columns + step];
            for (size_t j = step; j < columns; j++)
                a[i * columns + j] -= factor * a[step * columns + j];
        }
    }
    return pivot / largest;
}

static pc_status check_sums(const pc_basis *basis, pc_basis_facts *facts, pc_context *ctx) {
    for (pc_index e = 0; e < basis->element_count; e++) {
        double sum[16] = {0}, c[16];
        const pc_element *element = basis->element + e;
        for (size_t k = basis->start[e]; k < basis->start[e + 1]; k++) {
            pc_basis_coefficients(c, basis, e, k);
            for (int i = 0; i < 16; i++) {
                sum[i] += c[i];
                if (!element->irregular && c[i] < 0)
                    return pc_fail(ctx, PC_E_BUG, "vertex %u has a negative function on face %u",
                                   basis->point[k], element->face);
            }
        }
        for (int i = 0; i < 16; i++)
            facts->worst_sum = fmax(facts->worst_sum, fabs(sum[i] - 1));
        if (!(facts->worst_sum < 1e-10))
            return pc_fail(ctx, PC_E_BUG, "the functions on face %u do not sum to 1 (%g off, %zu functions)",
                           element->face, facts->worst_sum, basis->start[e + 1] - basis->start[e]);
    }
    return PC_OK;
}

/* Regular elements: each function once, 16 in all, independent. Marks their vertices as seen. */
static pc_status check_regular(const pc_basis *basis, pc_basis_facts *facts, uint8_t *seen, pc_context *ctx) {
    for (pc_index e = 0; e < basis->element_count; e++) {
        size_t count = basis->start[e + 1] - basis->start[e];
        double a[256], c[16];
        if (basis->element[e].irregular) continue;
        facts->most_points = count > facts->most_points ? (pc_index)count : facts->most_points;
        if (count != 16)
            return pc_fail(ctx, PC_E_BUG, "%zu functions on an element of face %u, not 16", count,
                           basis->element[e].face);
        for (size_t k = 0; k < count; k++) {
            pc_basis_coefficients(c, basis, e, basis->start[e] + k);
            for (size_t i = 0; i < 16; i++)
                a[16 * i + k] = c[i];
            seen[basis->point[basis->start[e] + k]] = 1;
        }
        double pivot = relative_rank(a, 16, 16);
        facts->least_pivot = fmin(facts->least_pivot, pivot);
        if (!(pivot > 1e-13))
            return pc_fail(ctx, PC_E_BUG, "the functions on face %u are not independent (pivot %g)",
                           basis->element[e].face, pivot);
    }
    return PC_OK;
}

/* Functions that live on irregular faces only. */
typedef struct unseen_functions {
    const pc_basis *basis;
    uint8_t *seen;    /* per vertex: known to be independent of all others */
    pc_index *column; /* per vertex, PC_NONE where it is not among `count` */
    pc_index *face;   /* irregular faces not shown yet, in the order of their numbers */
    size_t faces;
    pc_index count;
} unseen_functions;

static bool is_irregular(const pc_basis *basis, pc_index f) {
    const pc_index first = basis->face_start[f];
    return first < basis->face_start[f + 1] && basis->element[first].irregular;
}

/* Numbers the functions of faces `from` to `to` of the list; their smallest pivot, 1 where there are none. */
static pc_status pivot_of(double *pivot, unseen_functions *u, pc_context *ctx, size_t from, size_t to) {
    pc_status status = PC_OK;
    const pc_basis *basis = u->basis;
    double *a = NULL, c[16];
    size_t elements = 0, row = 0;
    u->count = 0;
    for (size_t i = from; i < to; i++) {
        const pc_index first = basis->face_start[u->face[i]], last = basis->face_start[u->face[i] + 1];
        elements += last - first;
        for (size_t k = basis->start[first]; k < basis->start[last]; k++)
            if (!u->seen[basis->point[k]] && u->column[basis->point[k]] == PC_NONE)
                u->column[basis->point[k]] = u->count++;
    }
    if (u->count) PC_TRY(pc_new(&a, ctx, 16 * elements * u->count));
    for (size_t i = from; i < to; i++)
        for (pc_index e = basis->face_start[u->face[i]]; e < basis->face_start[u->face[i] + 1];
             e++, row += 16)
            for (size_t k = basis->start[e]; u->count && k < basis->start[e + 1]; k++) {
                const pc_index j = u->column[basis->point[k]];
                pc_basis_coefficients(c, basis, e, k);
                for (size_t q = 0; q < 16 && j != PC_NONE; q++)
                    a[(row + q) * u->count + j] = c[q];
            }
    *pivot = u->count ? relative_rank(a, row, u->count) : 1;
done:
    pc_free(ctx, a);
    return status;
}

static void forget(unseen_functions *u, size_t from, size_t to, bool shown) {
    const pc_basis *basis = u->basis;
    for (size_t i = from; i < to; i++)
        for (size_t k = basis->start[basis->face_start[u->face[i]]];
             k < basis->start[basis->face_start[u->face[i] + 1]]; k++) {
            u->seen[basis->point[k]] |= shown;
            u->column[basis->point[k]] = PC_NONE;
        }
}

static const double least_pivot = 1e-13;

/* Shows faces one by one, each with what the others have shown before, as long as there is progress. */
static pc_status show_faces(unseen_functions *u, pc_basis_facts *facts, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t before;
    do {
        before = u->faces, u->faces = 0;
        for (size_t i = 0; i < before; i++) {
            double pivot;
            PC_TRY(pivot_of(&pivot, u, ctx, i, i + 1));
            const bool shown = pivot > least_pivot;
            forget(u, i, i + 1, shown);
            if (shown)
                facts->least_pivot = fmin(facts->least_pivot, pivot);
            else
                u->face[u->faces++] = u->face[i];
        }
    } while (u->faces && u->faces < before);
done:
    return status;
}

static bool shares_a_function(const unseen_functions *u, pc_index f) {
    const pc_basis *basis = u->basis;
    for (size_t k = basis->start[basis->face_start[f]]; k < basis->start[basis->face_start[f + 1]]; k++)
        if (u->column[basis->point[k]] != PC_NONE) return true;
    return false;
}

static void mark(unseen_functions *u, pc_index f) {
    const pc_basis *basis = u->basis;
    for (size_t k = basis->start[basis->face_start[f]]; k < basis->start[basis->face_start[f + 1]]; k++)
        if (!u->seen[basis->point[k]]) u->column[basis->point[k]] = 0;
}

/* Moves the faces that hang together with the first by unseen functions to the front; returns how many. */
static size_t gather(unseen_functions *u) {
    size_t count = 1, before;
    mark(u, u->face[0]);
    do {
        before = count;
        for (size_t i = count; i < u->faces; i++) {
            const pc_index f = u->face[i];
            if (!shares_a_function(u, f)) continue;
            mark(u, f);
            u->face[i] = u->face[count];
            u->face[count++] = f;
        }
    } while (count > before);
    forget(u, 0, count, false);
    return count;
}

/* What no face shows by itself: on one with several extraordinary corners functions can be dependent that are
 * independent on the faces around it together (Peters, Wu 2006). */
static pc_status show_together(unseen_functions *u, pc_basis_facts *facts, pc_context *ctx) {
    pc_status status = PC_OK;
    const size_t most = 500; /* faces: more are not eliminated in reasonable time */
    while (u->faces) {
        double pivot = 0;
        const size_t count = gather(u);
        if (count <= most) PC_TRY(pivot_of(&pivot, u, ctx, 0, count));
        if (!(pivot > least_pivot))
            PC_TRY(pc_fail(ctx, PC_E_MESH,
                           "the functions around irregular face %u (%zu faces) are not independent",
                           u->face[0], count));
        forget(u, 0, count, true);
        facts->least_pivot = fmin(facts->least_pivot, pivot);
        u->faces -= count;
        memmove(u->face, u->face + count, u->faces * sizeof *u->face);
    }
done:
    return status;
}

static pc_status check_irregular(const pc_basis *basis, pc_basis_facts *facts, uint8_t *seen,
                                 pc_context *ctx) {
    pc_status status = PC_OK;
    unseen_functions u = {.basis = basis};
    u.seen = seen;
    PC_TRY(pc_new(&u.face, ctx, basis->face_count));
    PC_TRY(pc_new(&u.column, ctx, basis->vertex_count));
    memset(u.column, 0xff, basis->vertex_count * sizeof *u.column);
    for (pc_index f = 0; f < basis->face_count; f++)
        if (is_irregular(basis, f)) u.face[u.faces++] = f;
    PC_TRY(show_faces(&u, facts, ctx));
    PC_TRY(show_together(&u, facts, ctx));
done:
    pc_free(ctx, u.face);
    pc_free(ctx, u.column);
    return status;
}

pc_status pc_basis_check(const pc_basis *basis, pc_basis_facts *facts, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_basis_facts own;
    uint8_t *seen = NULL;
    if (!facts) facts = &own;
    *facts = (pc_basis_facts){.least_pivot = 1};
    PC_TRY(pc_new(&seen, ctx, basis->vertex_count));
    PC_TRY(check_sums(basis, facts, ctx));
    PC_TRY(check_regular(basis, facts, seen, ctx));
    PC_TRY(check_irregular(basis, facts, seen, ctx));
    for (pc_index v = 0; v < basis->vertex_count; v++)
        facts->unused_vertices += !seen[v];
done:
    pc_free(ctx, seen);
    return status;
}
