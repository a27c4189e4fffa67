#include "fold.h"
#include "disk.h"
#include "memory.h"
#include "skin.h"
#include <string.h>

/* ---- Which faces ---- */

/* Feet that are opposed; with `torn` also those that are torn apart or held. */
static bool has_bad_feet(const pc_footpoints *feet, const pc_tspline *spline, pc_index f, bool torn) {
    enum { MOST_PER_SIDE = 16 };
    pc_vec3 point[MOST_PER_SIDE * MOST_PER_SIDE];
    const int n = feet->per_side;
    const pc_foot *foot = feet->foot + (size_t)f * (size_t)(n * n);
    for (int i = 0; i < n * n; i++) {
        double at[2];
        if (foot[i].opposed || (torn && foot[i].held)) return true;
        if (!torn) continue;
        pc_footpoints_at(at, feet, f, i);
        point[i] = pc_tspline_point(spline, pc_tspline_place(spline, f, at[0], at[1]));
    }
    for (int i = 0; torn && i < n * n; i++) {
        if ((i + 1) % n && pc_footpoints_torn(feet, f, i, i + 1, pc_distance(point[i], point[i + 1])))
            return true;
        if (i + n < n * n && pc_footpoints_torn(feet, f, i, i + n, pc_distance(point[i], point[i + n])))
            return true;
    }
    return false;
}

/* How far vertex v of the scan is from its place; 0 where it has none. */
static double spot_distance(const pc_matching *matching, const pc_tspline *spline, const pc_target *target,
                            pc_index v) {
    const pc_surface_place place = pc_correspondence_place(&matching->vertices, spline, v);
    if (place.element == PC_NONE) return 0;
    return pc_distance(pc_tspline_point(spline, place), pc_vec3_at(target->mesh->position, v));
}

/* The surface faces the other way at the place of vertex v. */
static bool is_opposed(const pc_matching *matching, const pc_tspline *spline, const pc_target *target,
                       pc_index v) {
    const pc_surface_place place = pc_correspondence_place(&matching->vertices, spline, v);
    if (place.element == PC_NONE) return false;
    const pc_surface_point x = pc_tspline_evaluate(spline, place);
    return pc_dot(pc_cross(x.s, x.t), pc_vec3_at(target->normal, v)) < 0;
}

pc_index pc_folds_find(uint8_t *folded, const pc_tspline *spline, const pc_target *target,
                       const pc_matching *matching, const pc_face_error *error, double tolerance) {
    pc_index count = 0;
    memset(folded, 0, spline->mesh.face_count);
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < matching->vertices.count; v++) {
        if (!is_opposed(matching, spline, target, v)) continue;
#pragma omp atomic write
        folded[matching->vertices.spot[v].face] = 1;
    }
#pragma omp parallel for schedule(dynamic, 64) reduction(+ : count)
    for (pc_index f = 0; f < spline->mesh.face_count; f++) {
        folded[f] = !spline->mesh.face[f].ghost && (!error || error[f].max > tolerance) &&
                    (folded[f] || has_bad_feet(&matching->feet, spline, f, error != NULL));
        count += folded[f];
    }
    return count;
}

/* ---- One disk ---- */

enum {
    FAR = 255,     /* a face that is in no ring */
    FIRST_RING = 2 /* of the smallest disks */
};

typedef struct opening {
    pc_matching *matching;
    const pc_tspline *spline;
    const pc_target *target;
    double tolerance;
    pc_skin skin; /* of the surface, or of what is around the group at hand */
    pc_adjacency skin_adjacency;
    bool whole;                         /* all of the surface */
    uint8_t *skin_inside, *scan_inside; /* per triangle */
    uint8_t *known;                     /* per vertex of the scan: near its place */
    pc_index *group;                    /* per face: of which group of folded faces, PC_NONE */
    uint8_t *ring;                      /* per face: steps from the group at hand; FAR */
    uint8_t last;                       /* the outermost ring */
    pc_disk above, below;               /* of the skin and of the scan */
} opening;

/* Faces that touch those of the last ring at a vertex become the next one. */
static void add_ring(opening *o) {
    const pc_tmesh *mesh = &o->spline->mesh;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        if (o->ring[f] != o->last) continue;
        pc_index h = mesh->face[f].first;
        do {
            pc_index g = h;
            do {
                const pc_index beside = mesh->half[g].face;
                if (beside != PC_NONE && !mesh->face[beside].ghost && o->ring[beside] == FAR)
                    o->ring[beside] = (uint8_t)(o->last + 1);
                g = pc_thalf_ccw(mesh, g);
            } while (g != h);
            h = mesh->half[h].next;
        } while (h != mesh->face[f].first);
    }
    o->last++;
}

static void start_rings(opening *o, pc_index group) {
    for (pc_index f = 0; f < o->spline->mesh.face_count; f++)
        o->ring[f] = o->group[f] == group ? 0 : FAR;
    o->last = 0;
}

/* Folded faces with no more than two others between them are one group; the number of groups. */
static pc_index find_groups(opening *o, const uint8_t *folded) {
    const pc_tmesh *mesh = &o->spline->mesh;
    pc_index groups = 0;
    memset(o->group, 0xff, mesh->face_count * sizeof *o->group);
    for (pc_index f = 0; f < mesh->face_count; f++) {
        if (!folded[f] || o->group[f] != PC_NONE) continue;
        o->group[f] = groups;
        for (bool more = true; more;) {
            more = false;
            start_rings(o, groups);
            add_ring(o);
            add_ring(o);
            add_ring(o);
            for (pc_index g = 0; g < mesh->face_count; g++)
                if (folded[g] && o->ring[g] != FAR && o->group[g] == PC_NONE)
                    o->group[g] = groups, more = true;
        }
        groups++;
    }
    return groups;
}

static pc_status cut_out_below(opening *o, pc_context *ctx) {
    const pc_mesh *scan = o->target->mesh;
#pragma omp parallel for schedule(static)
    for (pc_index t = 0; t < scan->face_count; t++) {
        bool in = true;
        for (size_t k = 0; k < 3 && in; k++) {
            const pc_index v = scan->triangle[3 * (size_t)t + k];
            in = o->known[v] && o->ring[o->matching->vertices.spot[v].face] != FAR;
        }
        o->scan_inside[t] = in;
    }
    return pc_disk_make(&o->below, ctx, scan, o->target->adjacency, o->scan_inside);
}

static pc_status cut_out_above(opening *o, pc_context *ctx) {
    const pc_basis *basis = &o->spline->basis;
#pragma omp parallel for schedule(static)
    for (pc_index t = 0; t < o->skin.mesh.face_count; t++)
        o->skin_inside[t] = o->ring[basis->element[o->skin.element[t]].face] != FAR;
    return pc_disk_make(&o->above, ctx, &o->skin.mesh, &o->skin_adjacency, o->skin_inside);
}

/* Of the outer faces of the disk, which are there to be relied on. */
static bool is_outer(const opening *o, pc_index f) {
    return o->ring[f] != FAR && o->ring[f] + 1 + o->last / 4 >= o->last;
}

/* The rim of what is below lies under the outermost faces, or on the border of the scan. */
static bool rims_agree(const opening *o) {
    for (pc_index i = 0; i < o->below.loop_count; i++) {
        const pc_index v = o->below.vertex[o->below.loop[i]];
        const pc_index f = o->matching->vertices.spot[v].face;
        if (o->target->adjacency->vertex_boundary[v]) continue;
        if (!o->known[v] || !is_outer(o, f)) return false;
    }
    return true;
}

static pc_status lay_above(opening *o, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_disk *disk = &o->above;
    double *length = NULL, *angle = NULL, total = 0;
    PC_TRY(pc_new(&length, ctx, 3 * (size_t)disk->mesh.face_count));
    PC_TRY(pc_new(&angle, ctx, disk->loop_count));
    for (size_t h = 0; h < 3 * (size_t)disk->mesh.face_count; h++) {
        const double *corner = o->skin.corner + 6 * (size_t)disk->triangle[h / 3];
        const double *a = corner + 2 * (h % 3), *b = corner + 2 * ((h + 1) % 3);
        length[h] = hypot(b[0] - a[0], b[1] - a[1]);
    }
    for (pc_index i = 0; i < disk->loop_count; i++) {
        const pc_index next = i + 1 < disk->loop_count ? i + 1 : 0;
        angle[i] = total;
        total += pc_distance(pc_vec3_at(disk->mesh.position, disk->loop[i]),
                             pc_vec3_at(disk->mesh.position, disk->loop[next]));
    }
    for (pc_index i = 0; i < disk->loop_count; i++)
        angle[i] *= 2 * PC_PI / total;
    PC_TRY(pc_disk_lay(&o->above, ctx, angle, length));
done:
    pc_free(ctx, length);
    pc_free(ctx, angle);
    return status;
}

/* First triangle of the skin on a face, or past it. */
static pc_index first_on_face(const opening *o, pc_index f) {
    const pc_index element = o->spline->basis.face_start[f];
    pc_index low = 0, high = o->skin.mesh.face_count;
    while (low < high) {
        const pc_index middle = low + (high - low) / 2;
        if (o->skin.element[middle] < element)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Where a place of a face is in the flat disk of the surface; false if it is not in it. */
static bool flat_place(pc_vec3 *flat, const opening *o, pc_index f, const double at[2]) {
    const pc_vec3 p = {at[0], at[1], 0};
    double least = INFINITY;
    *flat = (pc_vec3){0, 0, 0};
    for (pc_index t = first_on_face(o, f); t < o->skin.mesh.face_count; t++) {
        const double *c = o->skin.corner + 6 * (size_t)t;
        const pc_index part = pc_disk_find(&o->above, t);
        double weight[3];
        if (o->spline->basis.element[o->skin.element[t]].face != f) break;
        if (part == PC_NONE) continue;
        const double square = pc_closest_on_triangle(weight, p, (pc_vec3){c[0], c[1], 0},
                                                     (pc_vec3){c[2], c[3], 0}, (pc_vec3){c[4], c[5], 0});
        if (!(square < least)) continue;
        least = square;
        *flat = (pc_vec3){0, 0, 0};
        for (size_t k = 0; k < 3; k++)
            *flat = pc_madd(*flat, weight[k],
                            pc_vec3_at(o->above.mesh.position, o->above.mesh.triangle[3 * (size_t)part + k]));
    }
    return least < INFINITY;
}

/* Angles of the scan's rim from the places of its vertices, made to ascend: the mean of what they have
 * reached and of what they do not fall below, with a little of the length along the rim. False if they do
 * not go around once. */
static bool find_angles(double *angle, double *reached, const opening *o, const double *along) {
    const double even = 0.05;
    const pc_disk *disk = &o->below;
    const pc_index n = disk->loop_count;
    double before = 0, turned = 0, least = INFINITY;
    for (pc_index i = 0; i <= n; i++) {
        const pc_spot *spot = o->matching->vertices.spot + disk->vertex[disk->loop[i < n ? i : 0]];
        pc_vec3 flat;
        if (!flat_place(&flat, o, spot->face, spot->at)) return false;
        const double now = atan2(flat.y, flat.x);
        if (i == 0) turned = now;
        if (i > 0) turned += remainder(now - before, 2 * PC_PI);
        before = now;
        if (i < n) angle[i] = turned;
    }
    if (!(fabs(turned - angle[0] - 2 * PC_PI) < 1)) return false;
    for (pc_index i = 0; i < n; i++)
        reached[i] = fmax(angle[i], i ? reached[i - 1] : angle[0]);
    const double first = angle[0];
    for (pc_index i = n; i-- > 0;) {
        least = fmin(least, fmin(angle[i], first + 2 * PC_PI));
        const double ascending = (fmin(reached[i], first + 2 * PC_PI) + fmax(least, first)) / 2;
        angle[i] = (1 - even) * ascending + even * (first + 2 * PC_PI * along[i] / along[n]);
    }
    return true;
}

static pc_status lay_below(bool *laid, opening *o, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_disk *disk = &o->below;
    const pc_index n = disk->loop_count;
    double *length = NULL, *angle = NULL, *reached = NULL, *along = NULL;
    *laid = false;
    PC_TRY(pc_new(&length, ctx, 3 * (size_t)disk->mesh.face_count));
    PC_TRY(pc_new(&angle, ctx, n));
    PC_TRY(pc_new(&reached, ctx, n));
    PC_TRY(pc_new(&along, ctx, (size_t)n + 1));
    for (pc_index h = 0; h < 3 * disk->mesh.face_count; h++)
        length[h] = pc_distance(pc_vec3_at(disk->mesh.position, pc_tail(&disk->mesh, h)),
                                pc_vec3_at(disk->mesh.position, pc_head(&disk->mesh, h)));
    for (pc_index i = 0; i < n; i++)
        along[i + 1] =
            along[i] + pc_distance(pc_vec3_at(disk->mesh.position, disk->loop[i]),
                                   pc_vec3_at(disk->mesh.position, disk->loop[i + 1 < n ? i + 1 : 0]));
    if (!find_angles(angle, reached, o, along)) goto done;
    PC_TRY(pc_disk_lay(&o->below, ctx, angle, length));
    *laid = true;
done:
    pc_free(ctx, length);
    pc_free(ctx, angle);
    pc_free(ctx, reached);
    pc_free(ctx, along);
    return status;
}

static void match_feet(opening *o, pc_index f) {
    pc_footpoints *feet = &o->matching->feet;
    const int n = feet->per_side;
    for (int i = 0; i < n * n; i++) {
        pc_foot *foot = feet->foot + (size_t)f * (size_t)(n * n) + i;
        double at[2];
        pc_vec3 flat;
        pc_footpoints_at(at, feet, f, i);
        if (!flat_place(&flat, o, f, at)) continue;
        const pc_bvh_hit hit = pc_bvh_closest(&o->below.tree, flat, PC_NONE);
        *foot = (pc_foot){.triangle = o->below.triangle[hit.face], .held = true};
        memcpy(foot->weight, hit.weight, sizeof foot->weight);
        foot->point = pc_footpoints_point(o->target->mesh, foot);
    }
}

static void match_vertex(opening *o, pc_index local) {
    const pc_bvh_hit hit = pc_bvh_closest(&o->above.tree, pc_vec3_at(o->below.mesh.position, local), PC_NONE);
    const pc_index t = o->above.triangle[hit.face];
    const double *corner = o->skin.corner + 6 * (size_t)t;
    pc_spot spot = {.face = o->spline->basis.element[o->skin.element[t]].face, .held = true};
    for (size_t k = 0; k < 3; k++)
        for (size_t d = 0; d < 2; d++)
            spot.at[d] += hit.weight[k] * corner[2 * k + d];
    o->matching->vertices.spot[o->below.vertex[local]] = spot;
}

static pc_status try_disk(bool *opened, opening *o, pc_context *ctx) {
    pc_status status = PC_OK;
    bool laid;
    *opened = false;
    PC_TRY(cut_out_below(o, ctx));
    if (!o->below.loop_count || !rims_agree(o)) goto done;
    PC_TRY(cut_out_above(o, ctx));
    if (!o->above.loop_count) goto done;
    status = lay_above(o, ctx);
    if (status == PC_OK) status = lay_below(&laid, o, ctx);
    if (status == PC_E_NOCONV) { /* too deep a shape for numbers: the next ring may do */
        pc_context_clear_message(ctx);
        status = PC_OK;
        goto done;
    }
    PC_TRY(status);
    if (!laid) goto done;
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index i = 0; i < o->above.mesh.face_count; i++) {
        const pc_index t = o->above.triangle[i];
        const pc_index f = o->spline->basis.element[o->skin.element[t]].face;
        if (t == first_on_face(o, f)) match_feet(o, f);
    }
#pragma omp parallel for schedule(dynamic, 64)
    for (pc_index v = 0; v < o->below.mesh.vertex_count; v++)
        if (!o->below.adjacency.vertex_boundary[v] ||
            o->target->adjacency->vertex_boundary[o->below.vertex[v]])
            match_vertex(o, v);
    *opened = true;
done:
    pc_disk_free(&o->above, ctx);
    pc_disk_free(&o->below, ctx);
    return status;
}

/* ---- All of them ---- */

static void find_known(opening *o) {
    const double far = 3;
#pragma omp parallel for schedule(static)
    for (pc_index v = 0; v < o->matching->vertices.count; v++)
        o->known[v] = o->matching->vertices.spot[v].face != PC_NONE &&
                      (o->target->adjacency->vertex_boundary[v] ||
                       spot_distance(o->matching, o->spline, o->target, v) < far * o->tolerance);
}

static void free_skin(opening *o, pc_context *ctx) {
    pc_skin_free(&o->skin, ctx);
    pc_adjacency_free(&o->skin_adjacency, ctx);
    pc_free(ctx, o->skin_inside), o->skin_inside = NULL;
}

/* Of the faces in rings, or of all. */
static pc_status make_skin(opening *o, pc_context *ctx) {
    enum { STEPS = 4 };
    pc_status status = PC_OK;
    uint8_t *near = NULL;
    free_skin(o, ctx);
    PC_TRY(pc_new(&near, ctx, o->spline->mesh.face_count));
    for (pc_index f = 0; f < o->spline->mesh.face_count; f++)
        near[f] = o->ring[f] != FAR;
    PC_TRY(pc_skin_make(&o->skin, ctx, o->spline, STEPS, o->whole ? NULL : near));
    PC_TRY(pc_adjacency_make(&o->skin_adjacency, ctx, &o->skin.mesh));
    PC_TRY(pc_new(&o->skin_inside, ctx, o->skin.mesh.face_count));
done:
    pc_free(ctx, near);
    return status;
}

static void make_rings(opening *o, pc_index group, int rings) {
    start_rings(o, group);
    while (o->last < rings)
        add_ring(o);
}

/* Most disks are small: for these what is around the group will do, as far as it can't be taken for a hole of
 * the disk. */
static pc_status try_small_disk(bool *opened, opening *o, pc_context *ctx, pc_index group) {
    enum { SURROUNDINGS = 4 * FIRST_RING };
    pc_status status = PC_OK;
    make_rings(o, group, SURROUNDINGS);
    status = make_skin(o, ctx);
    if (status == PC_E_MESH) { /* it touches itself at a vertex */
        pc_context_clear_message(ctx);
        return PC_OK;
    }
    PC_TRY(status);
    make_rings(o, group, FIRST_RING);
    PC_TRY(try_disk(opened, o, ctx));
done:
    return status;
}

/* One ring after the other around a group of folded faces, until they can be laid flat. */
static pc_status open_group(bool *opened, opening *o, pc_context *ctx, pc_index group) {
    enum { MOST_RINGS = 24 };
    pc_status status = PC_OK;
    *opened = false;
    if (!o->whole) {
        PC_TRY(try_small_disk(opened, o, ctx, group));
        if (*opened) return PC_OK;
        o->whole = true; /* and stays so for the groups to come */
        PC_TRY(make_skin(o, ctx));
    }
    for (make_rings(o, group, FIRST_RING); !*opened && o->last <= MOST_RINGS; add_ring(o)) {
        PC_TRY(pc_check_interrupt(ctx));
        if ((o->last > 6 && o->last % 2) || (o->last > 12 && o->last % 4)) continue;
        PC_TRY(try_disk(opened, o, ctx));
    }
done:
    return status;
}

pc_status pc_folds_open(pc_matching *matching, pc_index *opened, pc_context *ctx, const pc_tspline *spline,
                        const pc_target *target, const uint8_t *folded, double tolerance) {
    pc_status status = PC_OK;
    opening o = {.matching = matching, .spline = spline, .target = target, .tolerance = tolerance};
    pc_index count = 0;
    PC_TRY(pc_new(&o.scan_inside, ctx, target->mesh->face_count));
    PC_TRY(pc_new(&o.known, ctx, target->mesh->vertex_count));
    PC_TRY(pc_new(&o.group, ctx, spline->mesh.face_count));
    PC_TRY(pc_new(&o.ring, ctx, spline->mesh.face_count));
    find_known(&o);
    const pc_index groups = find_groups(&o, folded);
    for (pc_index g = 0; g < groups; g++) {
        bool found;
        PC_TRY(open_group(&found, &o, ctx, g));
        count += found;
    }
    matching->let_go = tolerance;
    if (opened) *opened = count;
    pc_log(ctx, PC_LOG_DEBUG, "spline: %u of %u folds laid flat", count, groups);
done:
    free_skin(&o, ctx);
    pc_free(ctx, o.scan_inside);
    pc_free(ctx, o.known);
    pc_free(ctx, o.group);
    pc_free(ctx, o.ring);
    return status;
}
