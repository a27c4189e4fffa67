/* The quads and everything that is not one. */
#include "memory.h"
#include "random.h"
#include "scene.h"
#include "stroke.h"
#include "surface.h"
#include "vec3.h"

/* The n-gons cut into triangles; vertices of the quads first, then one middle per face of five or more
 * corners. */
typedef struct cut_faces {
    double *position;
    pc_index *triangle;
    pc_index *owner; /* per triangle: its face */
    pc_color *color;
    pc_index vertex_count, face_count;
} cut_faces;

static pc_index side_count(const pc_polymesh *q, pc_index face) {
    pc_index sides = 0;
    for (pc_index c = q->start[face]; c < q->start[face + 1]; c++)
        sides += !(q->corner_flat && q->corner_flat[c]);
    return sides;
}

static pc_color tint(pc_index sides) {
    switch (sides) {
    case 3:
        return 0xf2b33d;
    case 4:
        return 0xe4e3dd;
    case 5:
        return 0x63b7ac;
    case 6:
        return 0xa27fc4;
    default:
        return 0xe0659a;
    }
}

static void put_triangle(cut_faces *cut, pc_index face, pc_color color, pc_index a, pc_index b, pc_index c) {
    pc_index t = cut->face_count++;
    cut->triangle[3 * (size_t)t] = a, cut->triangle[3 * (size_t)t + 1] = b,
                      cut->triangle[3 * (size_t)t + 2] = c;
    cut->owner[t] = face, cut->color[t] = color;
}

static void cut_face(cut_faces *cut, const pc_polymesh *q, pc_index face) {
    const pc_index *v = q->corner + q->start[face];
    pc_index n = q->start[face + 1] - q->start[face];
    pc_color color = tint(side_count(q, face));
    if (n < 3) return;
    if (n == 3) {
        put_triangle(cut, face, color, v[0], v[1], v[2]);
    } else if (n == 4) { /* along the shorter diagonal */
        double d02 = pc_distance(pc_vec3_at(q->position, v[0]), pc_vec3_at(q->position, v[2]));
        double d13 = pc_distance(pc_vec3_at(q->position, v[1]), pc_vec3_at(q->position, v[3]));
        int k = d13 < d02;
        put_triangle(cut, face, color, v[k], v[k + 1], v[k + 2]);
        put_triangle(cut, face, color, v[k], v[k + 2], v[(k + 3) & 3]);
    } else {
        pc_vec3 middle = {0, 0, 0};
        for (pc_index k = 0; k < n; k++)
            middle = pc_madd(middle, 1.0 / n, pc_vec3_at(q->position, v[k]));
        pc_index m = cut->vertex_count++;
        pc_vec3_put(cut->position, m, middle);
        for (pc_index k = 0; k < n; k++)
            put_triangle(cut, face, color, v[k], v[k + 1 < n ? k + 1 : 0], m);
    }
}

static void free_cut(cut_faces *cut, pc_context *ctx) {
    pc_free(ctx, cut->position);
    pc_free(ctx, cut->triangle);
    pc_free(ctx, cut->owner);
    pc_free(ctx, cut->color);
}

static pc_status cut_all(cut_faces *cut, pc_context *ctx, const pc_polymesh *q) {
    pc_status status;
    size_t corners = q->start[q->face_count];
    PC_TRY(pc_new(&cut->position, ctx, 3 * ((size_t)q->vertex_count + q->face_count)));
    PC_TRY(pc_new(&cut->triangle, ctx, 3 * corners));
    PC_TRY(pc_new(&cut->owner, ctx, corners));
    PC_TRY(pc_new(&cut->color, ctx, corners));
    for (size_t i = 0; i < 3 * (size_t)q->vertex_count; i++)
        cut->position[i] = q->position[i];
    cut->vertex_count = q->vertex_count;
    for (pc_index f = 0; f < q->face_count; f++)
        cut_face(cut, q, f);
done:
    return status;
}

static pc_vec3 polygon_normal(const pc_polymesh *q, pc_index face) {
    pc_vec3 n = {0, 0, 0}, a = pc_vec3_at(q->position, q->corner[q->start[face]]);
    for (pc_index c = q->start[face] + 1; c + 1 < q->start[face + 1]; c++)
        n = pc_add(n, pc_cross(pc_sub(pc_vec3_at(q->position, q->corner[c]), a),
                               pc_sub(pc_vec3_at(q->position, q->corner[c + 1]), a)));
    return pc_unit(n);
}

static pc_status draw_edges(pc_picture *picture, pc_context *ctx, const pc_polymesh *q, double bias,
                            float width) {
    pc_stroke *stroke = NULL;
    size_t count = 0;
    pc_status status = pc_new(&stroke, ctx, q->start[q->face_count]);
    if (status != PC_OK) return status;
    for (pc_index f = 0; f < q->face_count; f++) {
        if (q->start[f + 1] - q->start[f] < 3) continue;
        pc_vec3 n = polygon_normal(q, f);
        for (pc_index c = q->start[f]; c < q->start[f + 1]; c++) {
            pc_index a = q->corner[c], b = q->corner[pc_polymesh_next(q, f, c)];
            /* drawn from both sides: the same line twice covers the same samples */
            pc_vec3 p = pc_vec3_at(q->position, a < b ? a : b), r = pc_vec3_at(q->position, a < b ? b : a);
            pc_stroke *s = &stroke[count++];
            pc_vec3_put(s->from, 0, p);
            pc_vec3_put(s->to, 0, r);
            s->normal[0] = (float)n.x, s->normal[1] = (float)n.y, s->normal[2] = (float)n.z;
            s->color = 0x1e3346, s->width = width;
        }
    }
    status = pc_stroke_draw(picture, ctx, stroke, count, bias);
    pc_free(ctx, stroke);
    return status;
}

/* Valence of interior vertices, 0 on borders: there the neighbours that follow and those that precede the
 * vertex in its faces differ. A T-junction is regular: the face on whose straight side it lies counts twice.
 */
static pc_status make_valence(uint8_t **valence, pc_context *ctx, const pc_polymesh *q) {
    pc_status status;
    uint64_t *balance = NULL;
    *valence = NULL;
    PC_TRY(pc_new(valence, ctx, q->vertex_count));
    PC_TRY(pc_new(&balance, ctx, q->vertex_count));
    for (pc_index f = 0; f < q->face_count; f++)
        for (pc_index first = q->start[f], end = q->start[f + 1], c = first; c < end; c++) {
            pc_index v = q->corner[c];
            balance[v] += pc_hash64(q->corner[c + 1 < end ? c + 1 : first]);
            balance[v] -= pc_hash64(q->corner[c > first ? c - 1 : end - 1]);
            int more = q->corner_flat && q->corner_flat[c] ? 2 : 1;
            if ((*valence)[v] + more < 255) (*valence)[v] = (uint8_t)((*valence)[v] + more);
        }
    for (size_t v = 0; v < q->vertex_count; v++)
        if (balance[v] != 0) (*valence)[v] = 0;
done:
    pc_free(ctx, balance);
    if (status != PC_OK) {
        pc_free(ctx, *valence);
        *valence = NULL;
    }
    return status;
}

static pc_color valence_color(int valence) {
    if (valence == 3) return 0xd62f3c;
    if (valence == 5) return 0x2166c4;
    return valence < 3 ? 0xf08a24 : 0x7a3fa8;
}

static void put_ball(pc_ball *ball, const pc_polymesh *q, size_t vertex, float radius, pc_color color) {
    pc_vec3_put(ball->centre, 0, pc_vec3_at(q->position, vertex));
    ball->radius = radius, ball->color = color;
}

/* Balls at irregular vertices, and smaller ones at T-junctions. */
static pc_status draw_irregular(pc_picture *picture, pc_context *ctx, const pc_polymesh *q, double edge) {
    pc_status status;
    uint8_t *valence = NULL;
    pc_ball *ball = NULL;
    size_t count = 0;
    PC_TRY(make_valence(&valence, ctx, q));
    for (size_t v = 0; v < q->vertex_count; v++)
        count += valence[v] != 0 && valence[v] != 4;
    size_t corners = q->corner_flat ? q->start[q->face_count] : 0;
    for (size_t c = 0; c < corners; c++)
        count += q->corner_flat[c];
    PC_TRY(pc_new(&ball, ctx, count));
    double pixel = pc_picture_pixel_length(picture, pc_picture_unit(picture));
    float radius = (float)fmin(6 * pixel, fmax(2 * pixel, 0.2 * edge));
    count = 0;
    for (size_t v = 0; v < q->vertex_count; v++)
        if (valence[v] != 0 && valence[v] != 4)
            put_ball(&ball[count++], q, v, radius, valence_color(valence[v]));
    for (size_t c = 0; c < corners; c++)
        if (q->corner_flat[c]) put_ball(&ball[count++], q, q->corner[c], 0.55F * radius, 0xe8912a);
    PC_TRY(pc_ball_draw(picture, ctx, ball, count));
done:
    pc_free(ctx, valence);
    pc_free(ctx, ball);
    return status;
}

static double mean_edge(const pc_polymesh *q) {
    double sum = 0;
    size_t count = 0;
    for (pc_index f = 0; f < q->face_count; f++)
        for (pc_index c = q->start[f]; c + 1 < q->start[f + 1]; c++) {
            double d =
                pc_distance(pc_vec3_at(q->position, q->corner[c]), pc_vec3_at(q->position, q->corner[c + 1]));
            if (isfinite(d)) sum += d, count++;
        }
    return count ? sum / (double)count : 0;
}

pc_status pc_scene_quads(pc_picture *picture, pc_context *ctx, const pc_polymesh *quads) {
    pc_status status;
    cut_faces cut = {0};
    PC_TRY(cut_all(&cut, ctx, quads));
    pc_surface s = pc_surface_of(cut.position, cut.vertex_count, cut.triangle, cut.face_count);
    s.face_color = cut.color, s.face_owner = cut.owner;
    s.flat = 0.6F, s.cavity = 0.6F;
    PC_TRY(pc_surface_draw(picture, ctx, &s));
    double edge = mean_edge(quads), pixel = pc_picture_pixel_length(picture, pc_picture_unit(picture));
    float width = (float)(fmin(1.5, fmax(0.25, 0.12 * edge / pixel)) * pc_picture_unit(picture));
    PC_TRY(draw_edges(picture, ctx, quads, 0.25 * pixel, width));
    PC_TRY(draw_irregular(picture, ctx, quads, edge));
done:
    free_cut(&cut, ctx);
    return status;
}
