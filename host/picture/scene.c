#include "scene.h"
#include "memory.h"
#include "scatter.h"
#include "stroke.h"
#include "surface.h"
#include "vec3.h"

enum { GLYPHS = 4500 };
static const pc_color ink = 0x17324d, plus = 0xd62f3c, minus = 0x2166c4;

pc_status pc_scene_scan(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh) {
    pc_surface s = pc_surface_of(mesh->position, mesh->vertex_count, mesh->triangle, mesh->face_count);
    return pc_surface_draw(picture, ctx, &s);
}

/* A direction inside a face: the corners' directions, laid into one tangent plane and averaged modulo the
 * symmetry. */
static pc_vec3 direction_at(pc_vec3 *normal, const pc_field *field, const pc_index *v, const float w[3]) {
    pc_vec3 n = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        n = pc_madd(n, w[k], pc_vec3_at(field->normal, v[k]));
    n = pc_unit(n);
    int first = w[1] > w[0] ? 1 : 0;
    if (w[2] > w[first]) first = 2;
    pc_vec3 x = pc_vec3_at(field->direction, v[first]);
    x = pc_unit(pc_sub(x, pc_scale(pc_dot(x, n), n)));
    pc_vec3 y = pc_cross(n, x);
    double re = 0, im = 0;
    for (int k = 0; k < 3; k++) {
        pc_vec3 d = pc_vec3_at(field->direction, v[k]);
        double angle = field->symmetry * atan2(pc_dot(d, y), pc_dot(d, x));
        re += w[k] * cos(angle), im += w[k] * sin(angle);
    }
    double angle = atan2(im, re) / field->symmetry;
    *normal = n;
    return pc_add(pc_scale(cos(angle), x), pc_scale(sin(angle), y));
}

static void put_stroke(pc_stroke *stroke, pc_vec3 a, pc_vec3 b, pc_vec3 n, float width) {
    pc_vec3_put(stroke->from, 0, a);
    pc_vec3_put(stroke->to, 0, b);
    stroke->normal[0] = (float)n.x, stroke->normal[1] = (float)n.y, stroke->normal[2] = (float)n.z;
    stroke->color = ink, stroke->width = width;
}

static pc_vec3 face_point(const pc_mesh *mesh, size_t face, const float w[3]) {
    pc_vec3 p = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        p = pc_madd(p, w[k], pc_vec3_at(mesh->position, mesh->triangle[3 * face + (size_t)k]));
    return p;
}

/* The lines of one glyph; returns how many. */
static size_t put_glyph(pc_stroke *stroke, pc_vec3 p, pc_vec3 x, pc_vec3 n, int symmetry, double half,
                        float width) {
    pc_vec3 y = pc_cross(n, x);
    if (symmetry != 4) half *= 1.2;
    put_stroke(stroke, pc_madd(p, -half, x), pc_madd(p, half, x), n, width);
    if (symmetry == 4) {
        put_stroke(stroke + 1, pc_madd(p, -half, y), pc_madd(p, half, y), n, width);
        return 2;
    }
    if (symmetry != 1) return 1;
    pc_vec3 tip = pc_madd(p, half, x), barb = pc_madd(tip, -0.6 * half, x);
    put_stroke(stroke + 1, tip, pc_madd(barb, 0.4 * half, y), n, width);
    put_stroke(stroke + 2, tip, pc_madd(barb, -0.4 * half, y), n, width);
    return 3;
}

static pc_status draw_glyphs(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh,
                             const pc_field *field) {
    pc_status status;
    pc_scatter scatter = {0};
    pc_stroke *stroke = NULL;
    double pixel = pc_picture_pixel_length(picture, pc_picture_unit(picture));
    /* about GLYPHS of them, so that small features get some too, but never a mere tangle */
    double spacing = fmin(19 * pixel, fmax(10 * pixel, sqrt(pc_scatter_area(mesh) / GLYPHS)));
    float width = (float)fmin(1.5, 0.085 * spacing / pixel) * (float)pc_picture_unit(picture);
    PC_TRY(pc_scatter_make(&scatter, ctx, mesh, spacing));
    PC_TRY(pc_new(&stroke, ctx, 3 * scatter.count));
    size_t lines = 0;
    for (size_t i = 0; i < scatter.count; i++) {
        const float *w = scatter.weight + 3 * i;
        pc_vec3 n, x = direction_at(&n, field, mesh->triangle + 3 * (size_t)scatter.face[i], w);
        if (!isfinite(x.x + x.y + x.z)) continue;
        pc_vec3 p = face_point(mesh, scatter.face[i], w);
        lines += put_glyph(stroke + lines, p, x, n, field->symmetry, 0.46 * spacing, width);
    }
    PC_TRY(pc_stroke_draw(picture, ctx, stroke, lines, 0.3 * spacing));
done:
    pc_free(ctx, stroke);
    pc_scatter_free(&scatter, ctx);
    return status;
}

static pc_status draw_singularities(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh,
                                    const pc_field *field) {
    size_t count = 0;
    for (size_t f = 0; f < field->face_count; f++)
        count += field->index[f] != 0;
    pc_ball *ball = NULL;
    pc_status status = pc_new(&ball, ctx, count);
    if (status != PC_OK) return status;
    const float third[3] = {1 / 3.0F, 1 / 3.0F, 1 / 3.0F};
    float unit = (float)pc_picture_pixel_length(picture, pc_picture_unit(picture));
    count = 0;
    for (size_t f = 0; f < field->face_count; f++) {
        const int8_t index = field->index[f];
        if (index == 0) continue;
        pc_ball *b = &ball[count++];
        pc_vec3_put(b->centre, 0, face_point(mesh, f, third));
        b->radius = unit * (index == 1 || index == -1 ? 7.0F : 10.5F);
        b->color = index > 0 ? plus : minus;
    }
    status = pc_ball_draw(picture, ctx, ball, count);
    pc_free(ctx, ball);
    return status;
}

pc_status pc_scene_field(pc_picture *picture, pc_context *ctx, const pc_mesh *mesh, const pc_field *field) {
    pc_status status;
    PC_TRY(draw_glyphs(picture, ctx, mesh, field));
    PC_TRY(draw_singularities(picture, ctx, mesh, field));
done:
    return status;
}
