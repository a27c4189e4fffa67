#include "repair.h"
#include "bisect.h"
#include "duplicates.h"
#include "fansplit.h"
#include "halfsort.h"
#include "memory.h"
#include "sheets.h"
#include "slivers.h"
#include "vec3.h"
#include <math.h>
#include <string.h>

/* The mesh on its way from soup to surface. Its vertices begin with those given, whether used or not. */
typedef struct workpiece {
    const pc_mesh *in;
    pc_mesh mesh;
    pc_index *face_source, *vertex_source;
    pc_index *half_source; /* per half-edge: the given half-edge on the same edge; until edges are cut */
    pc_index *wish;        /* per half-edge: the given vertex at its tail */
    pc_index *weld;        /* per given vertex: the one it was merged into */
    uint8_t *doubled;      /* per face: a dropped duplicate ran the other way round */
} workpiece;

pc_status pc_repair_check_input(pc_context *ctx, const pc_mesh *in) {
    for (size_t i = 0; i < 3 * (size_t)in->face_count; i++)
        if (in->triangle[i] >= in->vertex_count)
            return pc_fail(ctx, PC_E_MESH, "face %zu uses vertex %u of %u", i / 3, in->triangle[i],
                           in->vertex_count);
    for (size_t i = 0; i < 3 * (size_t)in->vertex_count; i++)
        if (!isfinite(in->position[i]))
            return pc_fail(ctx, PC_E_MESH, "vertex %zu has a coordinate that is not finite", i / 3);
    return PC_OK;
}

static pc_status begin_work(workpiece *w, pc_context *ctx) {
    pc_status status = PC_OK;
    size_t half_count = 3 * (size_t)w->in->face_count;
    PC_TRY(pc_mesh_copy(&w->mesh, ctx, w->in));
    PC_TRY(pc_new(&w->face_source, ctx, w->in->face_count));
    PC_TRY(pc_new(&w->vertex_source, ctx, w->in->vertex_count));
    PC_TRY(pc_new(&w->half_source, ctx, half_count));
    PC_TRY(pc_new(&w->wish, ctx, half_count));
    memcpy(w->wish, w->in->triangle, half_count * sizeof *w->wish);
    for (pc_index f = 0; f < w->in->face_count; f++)
        w->face_source[f] = f;
    for (pc_index v = 0; v < w->in->vertex_count; v++)
        w->vertex_source[v] = v;
    for (pc_index h = 0; h < half_count; h++)
        w->half_source[h] = h;
done:
    return status;
}

/* Keeps the faces whose `drop` is 0, and their order. `twin` may be NULL. */
static pc_status keep_faces(workpiece *w, pc_context *ctx, const uint8_t *drop, pc_index *twin) {
    pc_status status = PC_OK;
    pc_index kept = 0, *target = NULL;
    PC_TRY(pc_new(&target, ctx, w->mesh.face_count));
    for (pc_index f = 0; f < w->mesh.face_count; f++)
        target[f] = drop[f] ? PC_NONE : kept++;
    for (pc_index f = 0; f < w->mesh.face_count; f++) {
        pc_index g = target[f];
        if (g == PC_NONE) continue;
        w->face_source[g] = w->face_source[f];
        for (pc_index k = 0; k < 3; k++) {
            w->mesh.triangle[3 * g + k] = w->mesh.triangle[3 * f + k];
            w->half_source[3 * g + k] = w->half_source[3 * f + k];
            w->wish[3 * g + k] = w->wish[3 * f + k];
            if (!twin) continue;
            pc_index t = twin[3 * f + k];
            twin[3 * g + k] = t == PC_NONE || target[t / 3] == PC_NONE ? PC_NONE : 3 * target[t / 3] + t % 3;
        }
    }
    w->mesh.face_count = kept;
done:
    pc_free(ctx, target);
    return status;
}

/* Do two faces, and no duplicate of one another, share this edge? */
static bool inside_surface(const pc_mesh *mesh, const pc_index *weld, const pc_index *half, pc_index count) {
    return count == 2 && weld[pc_tail(mesh, pc_prev(half[0]))] != weld[pc_tail(mesh, pc_prev(half[1]))];
}

/* Marks the vertices that may gain by merging: those on an edge without exactly two faces (a seam may close
 * there) and on an edge of no length. The others are inside a surface; what they touch there is none of their
 * neighbours. */
static void mark_mergeable(uint8_t *mergeable, const pc_mesh *mesh, const pc_index *weld,
                           const pc_halfsort *sorted) {
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        for (pc_index i = sorted->start[v], end = sorted->start[v + 1], next; i < end; i = next) {
            pc_index w = pc_high_end(mesh, sorted->half[i]);
            next = pc_run_end(sorted, mesh, i, end);
            if (weld[v] == weld[w] || !inside_surface(mesh, weld, sorted->half + i, next - i))
                mergeable[v] = mergeable[w] = 1;
        }
}

/* Leaves in w->weld, and so in the faces, merges of mergeable vertices only. */
static pc_status keep_useful_merges(workpiece *w, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_halfsort sorted = {0};
    uint8_t *mergeable = NULL;
    pc_index *first = NULL;
    PC_TRY(pc_halfsort_make(&sorted, ctx, w->in));
    PC_TRY(pc_new(&mergeable, ctx, w->in->vertex_count));
    PC_TRY(pc_new(&first, ctx, w->in->vertex_count));
    mark_mergeable(mergeable, w->in, w->weld, &sorted);
    memset(first, 0xff, w->in->vertex_count * sizeof *first); /* PC_NONE */
    for (pc_index v = 0; v < w->in->vertex_count; v++) {
        pc_index place = w->weld[v];
        if (mergeable[v] && first[place] == PC_NONE) first[place] = v;
        w->weld[v] = mergeable[v] ? first[place] : v;
    }
done:
    pc_halfsort_free(&sorted, ctx);
    pc_free(ctx, mergeable);
    pc_free(ctx, first);
    return status;
}

static pc_status merge_vertices(workpiece *w, pc_context *ctx) {
    pc_status status = PC_OK;
    bool any = false;
    PC_TRY(pc_duplicates_of_vertices(&w->weld, ctx, w->in));
    for (pc_index v = 0; v < w->in->vertex_count; v++)
        any = any || w->weld[v] != v;
    if (!any) goto done;
    PC_TRY(keep_useful_merges(w, ctx));
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < 3 * (size_t)w->mesh.face_count; i++)
        w->mesh.triangle[i] = w->weld[w->mesh.triangle[i]];
done:
    return status;
}

static pc_status drop_degenerate(workpiece *w, pc_repair_report *report, pc_context *ctx) {
    pc_status status = PC_OK;
    uint8_t *drop = NULL;
    PC_TRY(pc_new(&drop, ctx, w->mesh.face_count));
    for (pc_index f = 0; f < w->mesh.face_count; f++) {
        const pc_index *t = w->mesh.triangle + 3 * (size_t)f;
        drop[f] = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
        if (drop[f]) pc_defect_note(&report->degenerate_faces, w->face_source[f]);
    }
    if (report->degenerate_faces.count) PC_TRY(keep_faces(w, ctx, drop, NULL));
done:
    pc_free(ctx, drop);
    return status;
}

/* Do two faces on the same vertices run the same way round? */
static bool same_turn(const pc_index *t, const pc_index *u) {
    int k = t[0] == u[0] ? 0 : t[0] == u[1] ? 1 : 2;
    return t[1] == u[(k + 1) % 3];
}

static pc_status drop_duplicates(workpiece *w, pc_repair_report *report, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *same = NULL, kept = 0;
    uint8_t *drop = NULL;
    PC_TRY(pc_new(&w->doubled, ctx, w->mesh.face_count));
    PC_TRY(pc_new(&drop, ctx, w->mesh.face_count));
    PC_TRY(pc_duplicates_of_faces(&same, ctx, &w->mesh));
    for (pc_index f = 0; f < w->mesh.face_count; f++) {
        const pc_index *t = w->mesh.triangle;
        drop[f] = same[f] != f;
        if (!drop[f]) continue;
        pc_defect_note(&report->duplicate_faces, w->face_source[f]);
        if (!same_turn(t + 3 * (size_t)f, t + 3 * (size_t)same[f])) w->doubled[same[f]] = 1;
    }
    if (report->duplicate_faces.count) {
        for (pc_index f = 0; f < w->mesh.face_count; f++)
            if (!drop[f]) w->doubled[kept++] = w->doubled[f];
        PC_TRY(keep_faces(w, ctx, drop, NULL));
    }
done:
    pc_free(ctx, same);
    pc_free(ctx, drop);
    return status;
}

/* A pair of opposite faces that hangs on a single edge which others share is a fold with nothing inside: the
 * face that is left of it goes too. */
static pc_status drop_folds(workpiece *w, pc_repair_report *report, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_halfsort sorted = {0};
    uint8_t *crowd = NULL, *drop = NULL; /* per half-edge: min(faces on its edge, 3) */
    pc_index count = 0;
    if (!memchr(w->doubled, 1, w->mesh.face_count)) return PC_OK;
    PC_TRY(pc_halfsort_make(&sorted, ctx, &w->mesh));
    PC_TRY(pc_new(&crowd, ctx, 3 * (size_t)w->mesh.face_count));
    PC_TRY(pc_new(&drop, ctx, w->mesh.face_count));
    for (pc_index v = 0; v < w->mesh.vertex_count; v++)
        for (pc_index i = sorted.start[v], end = sorted.start[v + 1], next; i < end; i = next) {
            next = pc_run_end(&sorted, &w->mesh, i, end);
            for (pc_index j = i; j < next; j++)
                crowd[sorted.half[j]] = next - i > 3 ? 3 : (uint8_t)(next - i);
        }
    for (pc_index f = 0; f < w->mesh.face_count; f++) {
        int alone = 0, crowded = 0;
        for (pc_index h = 3 * f; h < 3 * f + 3; h++)
            alone += crowd[h] == 1, crowded += crowd[h] == 3;
        drop[f] = w->doubled[f] && alone == 2 && crowded == 1;
        if (!drop[f]) continue;
        pc_defect_note(&report->duplicate_faces, w->face_source[f]);
        count++;
    }
    if (count) PC_TRY(keep_faces(w, ctx, drop, NULL));
done:
    pc_halfsort_free(&sorted, ctx);
    pc_free(ctx, crowd);
    pc_free(ctx, drop);
    return status;
}

static pc_status refuse_crowded(const pc_sheets *sheets, const workpiece *w, const pc_repair_report *report,
                                pc_context *ctx, const pc_repair_options *options) {
    pc_index h = report->crowded_edges.id[0], a = pc_tail(w->in, h), b = pc_head(w->in, h);
    double share = (double)sheets->crowded_count / sheets->edge_count;
    if (options->strict)
        return pc_fail(
            ctx, PC_E_MESH,
            "%u edges have more than two faces, the first is %u-%u at face %u: without strict checking they "
            "are cut into sheets",
            sheets->crowded_count, a, b, h / 3);
    if (sheets->crowded_count > PC_REPAIR_FEW_CROWDED && share > options->crowded_share)
        return pc_fail(
            ctx, PC_E_MESH,
            "%.0f %% of the edges (%u, the first is %u-%u at face %u) have more than two faces: this is no "
            "surface but perhaps all faces of a volume mesh; export its outer surface alone",
            100 * share, sheets->crowded_count, a, b, h / 3);
    return PC_OK;
}

static pc_status judge_sheets(const pc_sheets *sheets, const workpiece *w, pc_repair_report *report,
                              pc_context *ctx, const pc_repair_options *options) {
    for (pc_index i = 0; i < sheets->crowded_count; i++)
        pc_defect_note(&report->crowded_edges, w->half_source[sheets->crowded[i]]);
    for (pc_index i = 0; i < sheets->torn_count; i++)
        pc_defect_note(&report->torn_edges, w->half_source[sheets->torn[i]]);
    if (sheets->crowded_count) {
        pc_status status = refuse_crowded(sheets, w, report, ctx, options);
        if (status != PC_OK) return status;
    }
    if (sheets->torn_count && !options->tear_nonorientable) {
        pc_index h = report->torn_edges.id[0];
        return pc_fail(
            ctx, PC_E_MESH,
            "the piece with face %u has no orientation (like a Moebius strip): its sides change at %u edges, "
            "the first is %u-%u; cut it open there in a mesh editor, or drop one of its faces",
            h / 3, sheets->torn_count, pc_tail(w->in, h), pc_head(w->in, h));
    }
    return PC_OK;
}

/* Turns faces round: corner order a c b, so half-edge k becomes 2-k. `twin` follows. */
static void turn_faces(workpiece *w, pc_repair_report *report, pc_sheets *sheets) {
    for (pc_index f = 0; f < w->mesh.face_count; f++)
        for (pc_index h = 3 * f; h < 3 * f + 3; h++) {
            pc_index g = sheets->twin[h];
            if (g != PC_NONE && sheets->flip[g / 3]) sheets->twin[h] = g / 3 * 3 + 2 - g % 3;
        }
    for (pc_index f = 0; f < w->mesh.face_count; f++) {
        pc_index *t = w->mesh.triangle + 3 * (size_t)f, *s = w->half_source + 3 * (size_t)f;
        pc_index *twin = sheets->twin + 3 * (size_t)f, *wish = w->wish + 3 * (size_t)f, swap;
        if (!sheets->flip[f]) continue;
        pc_defect_note(&report->flipped_faces, w->face_source[f]);
        swap = t[1], t[1] = t[2], t[2] = swap;
        swap = wish[1], wish[1] = wish[2], wish[2] = swap;
        swap = s[0], s[0] = s[2], s[2] = swap;
        swap = twin[0], twin[0] = twin[2], twin[2] = swap;
    }
}

static pc_status refuse_shreds(pc_context *ctx, const workpiece *w, const pc_index *size,
                               const pc_sheets *sheets, double share) {
    pc_index shreds = 0, faces = 0, first = 0;
    for (pc_index i = 0; i < sheets->piece_count; i++)
        if (size[i] < PC_REPAIR_SHRED) shreds++, faces += size[i];
    if (shreds <= PC_REPAIR_FEW_SHREDS || faces <= share * w->mesh.face_count) return PC_OK;
    while (size[sheets->piece[first]] >= PC_REPAIR_SHRED)
        first++;
    return pc_fail(
        ctx, PC_E_MESH,
        "%u of %u triangles (the first is %u) are in %u pieces of fewer than %d: they are not joined; "
        "merge the vertices that should coincide, or leave such pieces out (min-component %d)",
        faces, w->mesh.face_count, w->face_source[first], shreds, PC_REPAIR_SHRED, PC_REPAIR_SHRED);
}

/* Leaves out pieces of fewer faces than asked; what is mostly shreds then is refused. */
static pc_status drop_small(workpiece *w, pc_repair_report *report, pc_context *ctx, pc_sheets *sheets,
                            const pc_repair_options *options) {
    pc_status status = PC_OK;
    pc_index *size = NULL, min_component = options->min_component;
    uint8_t *drop = NULL, *noted = NULL;
    PC_TRY(pc_new(&size, ctx, sheets->piece_count));
    PC_TRY(pc_new(&noted, ctx, sheets->piece_count));
    PC_TRY(pc_new(&drop, ctx, w->mesh.face_count));
    for (pc_index f = 0; f < w->mesh.face_count; f++)
        size[sheets->piece[f]]++;
    if (min_component < PC_REPAIR_SHRED) PC_TRY(refuse_shreds(ctx, w, size, sheets, options->shred_share));
    if (min_component < 2) goto done;
    for (pc_index f = 0; f < w->mesh.face_count; f++) {
        drop[f] = size[sheets->piece[f]] < min_component;
        if (!drop[f]) continue;
        pc_defect_note(&report->dropped_faces, w->face_source[f]);
        if (!noted[sheets->piece[f]]) pc_defect_note(&report->dropped_components, w->face_source[f]);
        noted[sheets->piece[f]] = 1;
    }
    if (report->dropped_faces.count) PC_TRY(keep_faces(w, ctx, drop, sheets->twin));
done:
    pc_free(ctx, size);
    pc_free(ctx, noted);
    pc_free(ctx, drop);
    return status;
}

/* Makes room for vertices that stand where their source stands. */
static pc_status append_vertices(workpiece *w, pc_context *ctx, const pc_index *source, pc_index count) {
    pc_status status = PC_OK;
    size_t old = w->mesh.vertex_count, total = old + count;
    if (total >= PC_NONE - 1) return pc_fail(ctx, PC_E_MESH, "%zu vertices exceed 32-bit indices", total);
    PC_TRY(pc_resize(&w->mesh.position, ctx, 3 * total));
    PC_TRY(pc_resize(&w->vertex_source, ctx, total));
    for (size_t i = 0; i < count; i++) {
        memcpy(w->mesh.position + 3 * (old + i), w->mesh.position + 3 * (size_t)source[i],
               3 * sizeof(double));
        w->vertex_source[old + i] = w->vertex_source[source[i]];
    }
    w->mesh.vertex_count = (pc_index)total;
done:
    return status;
}

static pc_status split_fans(workpiece *w, pc_repair_report *report, pc_context *ctx,
                            const pc_sheets *sheets) {
    pc_status status = PC_OK;
    pc_index *source = NULL, count;
    uint8_t *noted = NULL;
    PC_TRY(pc_fansplit_vertices(&source, &count, ctx, &w->mesh, sheets->twin, w->wish));
    if (!count) goto done;
    PC_TRY(pc_new(&noted, ctx, w->mesh.vertex_count));
    for (pc_index i = 0; i < count; i++) {
        pc_index v = source[i];
        if (!noted[v])
            pc_defect_note(sheets->vertex_cut[v] ? &report->cut_vertices : &report->split_vertices, v);
        noted[v] = 1;
    }
    PC_TRY(append_vertices(w, ctx, source, count));
done:
    pc_free(ctx, source);
    pc_free(ctx, noted);
    return status;
}

/* A new vertex at the place of another that it has an edge to moves along its own edge, which stays straight.
 * That takes collinear faces, so it hardly ever happens. */
static void part_coincident(pc_mesh *mesh, pc_index old, const pc_index *parent) {
    bool found = true;
    for (int round = 1; found && round < 64; round++) {
        double share = 0.25 + 0.5 * fmod(0.6180339887498949 * round, 1); /* never the same one twice */
        found = false;
        for (pc_index h = 0; h < 3 * mesh->face_count; h++) {
            pc_index a = pc_tail(mesh, h), b = pc_head(mesh, h), v = a > b ? a : b;
            if (v < old || pc_distance(pc_vec3_at(mesh->position, a), pc_vec3_at(mesh->position, b)) > 0)
                continue;
            pc_vec3 p = pc_vec3_at(mesh->position, parent[2 * (size_t)(v - old)]);
            pc_vec3 q = pc_vec3_at(mesh->position, parent[2 * (size_t)(v - old) + 1]);
            pc_vec3_put(mesh->position, v, pc_madd(p, share, pc_sub(q, p)));
            found = true;
        }
    }
}

static pc_status cut_edges(workpiece *w, pc_repair_report *report, pc_context *ctx, const pc_sheets *sheets) {
    pc_status status = PC_OK;
    pc_index *midpoint = NULL, *parent = NULL, *source = NULL, old = w->mesh.vertex_count;
    pc_mesh cut = {0};
    size_t count;
    if (!sheets->crowded_count && !sheets->torn_count) return PC_OK;
    PC_TRY(pc_new(&midpoint, ctx, 3 * (size_t)w->mesh.face_count));
    PC_TRY(pc_fansplit_edges(midpoint, &parent, &count, ctx, &w->mesh, sheets->twin));
    if (!count) goto done;
    for (pc_index h = 0; h < 3 * w->mesh.face_count; h++)
        if (midpoint[h] != PC_NONE && (sheets->twin[h] == PC_NONE || h < sheets->twin[h]))
            pc_defect_note(&report->cut_edges, w->half_source[h]);
    PC_TRY(pc_bisect_edges(&cut, &source, ctx, &w->mesh, midpoint, parent, count));
    PC_TRY(pc_resize(&w->vertex_source, ctx, (size_t)old + count));
    for (size_t i = 0; i < count; i++)
        w->vertex_source[old + i] = w->vertex_source[parent[2 * i]];
    part_coincident(&cut, old, parent);
    for (pc_index f = 0; f < cut.face_count; f++)
        source[f] = w->face_source[source[f]];
    pc_mesh_free(&w->mesh, ctx);
    pc_free(ctx, w->face_source);
    w->mesh = cut, cut = (pc_mesh){0};
    w->face_source = source, source = NULL;
done:
    pc_free(ctx, midpoint);
    pc_free(ctx, parent);
    pc_free(ctx, source);
    pc_mesh_free(&cut, ctx);
    return status;
}

/* A given vertex that is gone was merged where another at its place is left, else nothing used it. */
static void note_gone(const workpiece *w, pc_repair_report *report, const pc_index *target, uint8_t *alive) {
    for (pc_index v = 0; v < w->mesh.vertex_count; v++)
        if (target[v]) alive[w->weld[w->vertex_source[v]]] = 1;
    for (pc_index v = 0; v < w->in->vertex_count; v++)
        if (!target[v])
            pc_defect_note(alive[w->weld[v]] ? &report->merged_vertices : &report->isolated_vertices, v);
}

/* Only vertices in use remain, in order. */
static pc_status drop_unused(workpiece *w, pc_repair_report *report, pc_context *ctx) {
    pc_status status = PC_OK;
    pc_index *target = NULL, kept = 0;
    uint8_t *alive = NULL;
    PC_TRY(pc_new(&target, ctx, w->mesh.vertex_count));
    PC_TRY(pc_new(&alive, ctx, w->in->vertex_count));
    for (size_t i = 0; i < 3 * (size_t)w->mesh.face_count; i++)
        target[w->mesh.triangle[i]] = 1;
    note_gone(w, report, target, alive);
    for (pc_index v = 0; v < w->mesh.vertex_count; v++) {
        if (!target[v]) continue;
        target[v] = kept;
        w->vertex_source[kept] = w->vertex_source[v];
        memmove(w->mesh.position + 3 * (size_t)kept++, w->mesh.position + 3 * (size_t)v, 3 * sizeof(double));
    }
    for (size_t i = 0; i < 3 * (size_t)w->mesh.face_count; i++)
        w->mesh.triangle[i] = target[w->mesh.triangle[i]];
    w->mesh.vertex_count = kept;
done:
    pc_free(ctx, target);
    pc_free(ctx, alive);
    return status;
}

static pc_status cure_slivers(workpiece *w, pc_repair_report *report, pc_context *ctx) {
    pc_status status = PC_OK;
    uint8_t *zero = NULL;
    pc_index *source = NULL;
    pc_sliver_count count;
    pc_index faces = w->mesh.face_count;
    PC_TRY(pc_new(&zero, ctx, faces));
    PC_TRY(pc_new(&source, ctx, faces));
    memcpy(source, w->face_source, faces * sizeof *source);
    PC_TRY(pc_slivers_cure(&count, zero, ctx, &w->mesh, w->face_source));
    for (pc_index f = 0; f < faces; f++)
        if (zero[f]) pc_defect_note(&report->zero_area_faces, source[f]);
    report->cured_zero_area = count.cured;
done:
    pc_free(ctx, zero);
    pc_free(ctx, source);
    return status;
}

static pc_status make_surface(workpiece *w, pc_repair_report *report, pc_context *ctx,
                              const pc_repair_options *options) {
    pc_status status = PC_OK;
    pc_sheets sheets = {0};
    PC_TRY(pc_sheets_make(&sheets, ctx, &w->mesh));
    PC_TRY(judge_sheets(&sheets, w, report, ctx, options));
    turn_faces(w, report, &sheets);
    PC_TRY(drop_small(w, report, ctx, &sheets, options));
    PC_TRY(split_fans(w, report, ctx, &sheets));
    PC_TRY(cut_edges(w, report, ctx, &sheets));
done:
    pc_sheets_free(&sheets, ctx);
    return status;
}

/* Where each given vertex is now: in its own name, else the first of those at its place. */
static pc_status find_targets(pc_repair_report *report, pc_context *ctx, const workpiece *w) {
    pc_status status = PC_OK;
    pc_index given = w->in->vertex_count, *place = NULL, *target;
    PC_TRY(pc_new(&report->vertex_target, ctx, given));
    PC_TRY(pc_new(&place, ctx, given));
    target = report->vertex_target;
    for (pc_index v = 0; v < given; v++)
        target[v] = place[v] = PC_NONE;
    for (pc_index v = w->mesh.vertex_count; v-- > 0;)
        target[w->vertex_source[v]] = place[w->weld[w->vertex_source[v]]] = v;
    for (pc_index v = 0; v < given; v++)
        if (target[v] == PC_NONE) target[v] = place[w->weld[v]];
done:
    pc_free(ctx, place);
    return status;
}

static pc_status hand_over(pc_mesh *out, pc_repair_report *report, pc_context *ctx, workpiece *w) {
    pc_status status = PC_OK;
    const pc_mesh *in = w->in;
    PC_TRY(find_targets(report, ctx, w));
    PC_TRY(pc_resize(&w->mesh.position, ctx, 3 * (size_t)w->mesh.vertex_count));
    PC_TRY(pc_resize(&w->mesh.triangle, ctx, 3 * (size_t)w->mesh.face_count));
    PC_TRY(pc_resize(&w->vertex_source, ctx, w->mesh.vertex_count));
    PC_TRY(pc_resize(&w->face_source, ctx, w->mesh.face_count));
    report->given_vertex_count = in->vertex_count;
    report->vertex_count = w->mesh.vertex_count, report->face_count = w->mesh.face_count;
    report->vertex_source = w->vertex_source, w->vertex_source = NULL;
    report->face_source = w->face_source, w->face_source = NULL;
    report->changed =
        w->mesh.vertex_count != in->vertex_count || w->mesh.face_count != in->face_count ||
        memcmp(w->mesh.triangle, in->triangle, 3 * sizeof(pc_index) * (size_t)in->face_count) != 0;
    *out = w->mesh, w->mesh = (pc_mesh){0};
done:
    return status;
}

pc_status pc_repair(pc_mesh *out, pc_repair_report *report, pc_context *ctx, const pc_mesh *in,
                    const pc_repair_options *options) {
    pc_status status = PC_OK;
    workpiece w = {.in = in};
    *out = (pc_mesh){0};
    *report = (pc_repair_report){0};
    PC_TRY(pc_repair_check_input(ctx, in));
    PC_TRY(begin_work(&w, ctx));
    PC_TRY(merge_vertices(&w, ctx));
    PC_TRY(drop_degenerate(&w, report, ctx));
    PC_TRY(drop_duplicates(&w, report, ctx));
    PC_TRY(drop_folds(&w, report, ctx));
    PC_TRY(make_surface(&w, report, ctx, options));
    PC_TRY(drop_unused(&w, report, ctx));
    if (!w.mesh.face_count) {
        status = pc_fail(ctx, PC_E_MESH,
                         "no face is left: %u degenerate and %u duplicate ones, %u in pieces under %u",
                         report->degenerate_faces.count, report->duplicate_faces.count,
                         report->dropped_faces.count, options->min_component);
        goto done;
    }
    PC_TRY(cure_slivers(&w, report, ctx));
    PC_TRY(hand_over(out, report, ctx, &w));
done:
    pc_mesh_free(&w.mesh, ctx);
    pc_free(ctx, w.face_source);
    pc_free(ctx, w.vertex_source);
    pc_free(ctx, w.half_source);
    pc_free(ctx, w.wish);
    pc_free(ctx, w.weld);
    pc_free(ctx, w.doubled);
    if (status != PC_OK) pc_repair_report_free(report, ctx);
    return status;
}

void pc_repair_report_free(pc_repair_report *report, pc_context *ctx) {
    if (!report) return;
    pc_free(ctx, report->vertex_source);
    pc_free(ctx, report->face_source);
    pc_free(ctx, report->vertex_target);
    report->vertex_source = report->face_source = report->vertex_target = NULL;
}
