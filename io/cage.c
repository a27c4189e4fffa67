#include "cage.h"
#include "memory.h"
#include "polyfile.h"
#include "vec3.h"
#include <string.h>

/* A vertex on the border, its neighbours along it, and the spline's point there. */
typedef struct rim {
    pc_index vertex, before, after;
    bool corner; /* of one face only: the subdivision keeps it */
    pc_vec3 target, miss;
} rim;

typedef struct making {
    const pc_tspline *spline;
    pc_polymesh *cage;
    pc_index *of_vertex; /* per vertex of the T-mesh: the cage's; PC_NONE where no face of it is */
    rim *rim;
    pc_index rim_count;
} making;

static bool is_real(const pc_tmesh *mesh, pc_index h) {
    return mesh->half[h].face != PC_NONE && !mesh->face[mesh->half[h].face].ghost;
}

static bool is_rim(const pc_tmesh *mesh, pc_index h) {
    return is_real(mesh, h) && !is_real(mesh, mesh->half[h].twin);
}

static pc_status make_faces(making *m, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    pc_index vertices = 0, faces = 0, corners = 0;
    PC_TRY(pc_new(&m->of_vertex, ctx, mesh->vertex_count));
    memset(m->of_vertex, 0xff, mesh->vertex_count * sizeof *m->of_vertex);
    for (pc_index h = 0; h < mesh->half_count; h++) {
        if (is_real(mesh, h)) m->of_vertex[mesh->half[h].tail] = 0, corners++;
        m->rim_count += is_rim(mesh, h);
    }
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (m->of_vertex[v] != PC_NONE) m->of_vertex[v] = vertices++;
    for (pc_index f = 0; f < mesh->face_count; f++)
        faces += !mesh->face[f].ghost;
    PC_TRY(pc_polymesh_make(m->cage, ctx, vertices, faces, corners));
    faces = corners = 0;
    for (pc_index f = 0; f < mesh->face_count; f++) {
        pc_index h = mesh->face[f].first;
        if (mesh->face[f].ghost) continue;
        do {
            m->cage->corner[corners] = m->of_vertex[mesh->half[h].tail];
            m->cage->corner_flat[corners++] = !pc_thalf_turns(mesh, h);
            h = mesh->half[h].next;
        } while (h != mesh->face[f].first);
        m->cage->start[++faces] = corners;
    }
done:
    return status;
}

static pc_status take_points(making *m, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_tmesh *mesh = &m->spline->mesh;
    pc_index count = 0;
    PC_TRY(pc_new(&m->rim, ctx, m->rim_count));
    for (pc_index v = 0; v < mesh->vertex_count; v++)
        if (m->of_vertex[v] != PC_NONE)
            memcpy(m->cage->position + 3 * (size_t)m->of_vertex[v], m->spline->position + 3 * (size_t)v,
                   3 * sizeof(double));
    for (pc_index h = 0; h < mesh->half_count; h++) {
        double at[2];
        if (!is_rim(mesh, h)) continue;
        pc_index last = h;
        while (is_real(mesh, last))
            last = pc_thalf_ccw(mesh, last);
        pc_thalf_place(at, mesh, h);
        m->rim[count++] =
            (rim){.vertex = m->of_vertex[mesh->half[h].tail],
                  .before = m->of_vertex[pc_thalf_head(mesh, last)],
                  .after = m->of_vertex[pc_thalf_head(mesh, h)],
                  .corner = last == pc_thalf_ccw(mesh, h),
                  .target = pc_tspline_point(m->spline,
                                             pc_tspline_place(m->spline, mesh->half[h].face, at[0], at[1]))};
    }
done:
    return status;
}

/* The limit on a border is the cubic B-spline curve of its vertices. By Jacobi's iteration, which takes two
 * thirds of the error in each round at least. */
static void fit_border(making *m) {
    enum { ROUNDS = 100 };
    double *position = m->cage->position;
    for (int round = 0; round < ROUNDS; round++) {
        for (pc_index i = 0; i < m->rim_count; i++) {
            rim *r = m->rim + i;
            pc_vec3 sum = pc_add(pc_vec3_at(position, r->before), pc_vec3_at(position, r->after));
            sum = pc_madd(sum, 4, pc_vec3_at(position, r->vertex));
            r->miss = pc_madd(r->target, -1.0 / 6, sum);
            if (r->corner) r->miss = pc_sub(r->target, pc_vec3_at(position, r->vertex));
        }
        for (pc_index i = 0; i < m->rim_count; i++) {
            const rim *r = m->rim + i;
            pc_vec3_put(position, r->vertex, pc_add(pc_vec3_at(position, r->vertex), r->miss));
        }
    }
}

pc_status pc_cage_make(pc_polymesh *cage, pc_context *ctx, const pc_tspline *spline) {
    pc_status status = PC_OK;
    making m = {.spline = spline, .cage = cage};
    *cage = (pc_polymesh){0};
    PC_TRY(make_faces(&m, ctx));
    PC_TRY(take_points(&m, ctx));
    fit_border(&m);
done:
    pc_free(ctx, m.of_vertex);
    pc_free(ctx, m.rim);
    if (status != PC_OK) pc_polymesh_free(cage, ctx);
    return status;
}

pc_status pc_cage_write(pc_context *ctx, const pc_tspline *spline, const char *path, bool force) {
    pc_status status = PC_OK;
    pc_polymesh cage = {0};
    PC_TRY(pc_cage_make(&cage, ctx, spline));
    PC_TRY(pc_polyfile_write_obj(ctx, &cage, path, force));
done:
    pc_polymesh_free(&cage, ctx);
    return status;
}
