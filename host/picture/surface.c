#include "surface.h"
#include "memory.h"
#include "occlusion.h"
#include "pick.h"
#include "raster.h"

typedef struct lights {
    float key[3], half[3], fill[3], up[3], back[3]; /* unit, from the surface to the light */
    float pole[3];                                  /* around which the reflected stripes lie */
} lights;

typedef struct tone {
    float linear[256];
    uint8_t encoded[4096];
} tone;

/* The face a sample sees, ready to be interpolated. */
typedef struct facet {
    pc_index face;
    const pc_index *v;
    const float *a, *b, *c; /* projected corners */
    float inverse;          /* of twice the area on the screen */
    float normal[3];        /* of the face, unit; only where the surface is not all smooth */
    float blur;             /* stripes from one sample to the next; only where it has any */
} facet;

typedef struct shader {
    const pc_surface *surface;
    const pc_picture *picture;
    const pc_pane *pane;
    const float *screen, *normal, *shade;
    const pc_vec3 *owner_normal;
    lights light;
    tone tone;
} shader;

pc_surface pc_surface_of(const double *position, pc_index vertex_count, const pc_index *triangle,
                         pc_index face_count) {
    return (pc_surface){.vertex_count = vertex_count,
                        .face_count = face_count,
                        .position = position,
                        .triangle = triangle,
                        .map = &pc_colormap_diverging,
                        .low = -1,
                        .high = 1,
                        .color = 0xdcd6cd,
                        .cavity = 1};
}

static pc_vec3 face_normal(const double *position, const pc_index *v) {
    pc_vec3 a = pc_vec3_at(position, v[0]);
    return pc_cross(pc_sub(pc_vec3_at(position, v[1]), a), pc_sub(pc_vec3_at(position, v[2]), a));
}

void pc_surface_normals(float *normal, const double *position, pc_index vertex_count,
                        const pc_index *triangle, pc_index face_count) {
    for (size_t i = 0; i < 3 * (size_t)vertex_count; i++)
        normal[i] = 0;
    for (size_t f = 0; f < face_count; f++) {
        pc_vec3 n = face_normal(position, triangle + 3 * f);
        /* area to the power 1/2: large faces count more, but huge slivers do not drown the rest */
        double length = pc_norm(n);
        if (!(length > 0) || !isfinite(length)) continue;
        double weight = 1 / sqrt(length);
        for (int k = 0; k < 3; k++) {
            float *sum = normal + 3 * (size_t)triangle[3 * f + (size_t)k];
            sum[0] += (float)(weight * n.x), sum[1] += (float)(weight * n.y), sum[2] += (float)(weight * n.z);
        }
    }
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < vertex_count; i++) {
        float *n = normal + 3 * i, length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        float inverse = length > 0 && isfinite(length) ? 1 / length : 0;
        for (int k = 0; k < 3; k++)
            n[k] = inverse > 0 ? n[k] * inverse : 0;
    }
}

static void in_view(float out[3], const pc_camera *c, double x, double y, double z) {
    pc_vec3 v = pc_unit(pc_add(pc_add(pc_scale(x, c->right), pc_scale(y, c->up)), pc_scale(z, c->back)));
    out[0] = (float)v.x, out[1] = (float)v.y, out[2] = (float)v.z;
}

static void make_lights(lights *l, const pc_camera *c) {
    in_view(l->key, c, -0.5, 0.65, 0.7);
    in_view(l->fill, c, 0.9, -0.1, 0.45);
    in_view(l->half, c, -0.25, 0.33, 0.85); /* about half way between the key light and the viewer */
    in_view(l->up, c, 0, 1, 0.15);
    in_view(l->back, c, 0, 0, 1);
    in_view(l->pole, c, 0.42, 0.86, 0.28);
}

static void make_tone(tone *t) {
    for (int i = 0; i < 256; i++)
        t->linear[i] = pc_color_to_linear(i);
    for (int i = 0; i < 4096; i++)
        t->encoded[i] = (uint8_t)pc_color_from_linear((float)i / 4095.0F);
}

static float dot3(const float a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void unit3(float v[3]) {
    float square = dot3(v, v), inverse = square > 0 ? 1 / sqrtf(square) : 0;
    v[0] *= inverse, v[1] *= inverse, v[2] *= inverse;
}

/* Light from the key, fill and sky lights, and the gloss of the key light, on a surface with normal n. */
static float light_on(float *gloss, const lights *l, const float n[3], float facing) {
    float key = pc_greater(0, 0.88F * dot3(n, l->key) + 0.12F), fill = pc_greater(0, dot3(n, l->fill));
    float g = pc_greater(0, dot3(n, l->half));
    g *= g, g *= g, g *= g, g *= g;
    *gloss = 0.07F * g * g; /* 32nd power */
    float light = 0.33F + 0.19F * dot3(n, l->up) + 0.72F * key + 0.13F * fill;
    return light * (0.80F + 0.20F * facing); /* rims turn a little darker */
}

static pc_color lit(const shader *s, pc_color base, float n[3], float shade) {
    float facing = dot3(n, s->light.back), gloss;
    int behind = facing < 0;
    if (behind) n[0] = -n[0], n[1] = -n[1], n[2] = -n[2], facing = -facing;
    float light = light_on(&gloss, &s->light, n, facing);
    light += s->surface->even * (1 - light);
    float dark = shade < 0 ? shade : 0.35F * shade;
    light *= pc_greater(0.25F, pc_lesser(1.25F, 1 + 0.62F * s->surface->cavity * dark));
    if (shade < 0) gloss *= pc_greater(0, 1 + shade);
    if (behind) base = pc_color_mix(base, 0x8a6f5c, 0.45F), light *= 0.8F, gloss = 0;
    pc_color out = 0;
    for (int k = 0; k < 3; k++) {
        float v = s->tone.linear[pc_color_channel(base, k)] * light + gloss;
        out = out << 8 | s->tone.encoded[v >= 1 ? 4095 : v > 0 ? (int)(4095 * v) : 0];
    }
    return out;
}

/* The face's own normal, or that of the n-gon it is part of. */
static void flat_normal(float n[3], const shader *s, const facet *t) {
    const pc_surface *f = s->surface;
    pc_vec3 m =
        s->owner_normal ? s->owner_normal[f->face_owner[t->face]] : pc_unit(face_normal(f->position, t->v));
    n[0] = (float)m.x, n[1] = (float)m.y, n[2] = (float)m.z;
}

/* The ray from the eye to a sample of the pane, mirrored by the surface with normal n at `depth`, meets a
 * sphere around the model; where among the stripes that lie on it around an oblique axis, so that flat pieces
 * and cylinders along the picture show some too. A smooth function of place and normal: whatever has a kink
 * is the surface. Also how squarely the surface is seen, 0..1. */
static float stripe_at(float *facing, const shader *s, float x, float y, float depth, const float n[3]) {
    const pc_camera *c = &s->pane->camera;
    const double w = c->distance / (1 + (double)depth), radius = c->distance / 3;
    double across = ((double)x - c->column) / (c->scale * c->distance);
    double along = (c->row - (double)y) / (c->scale * c->distance);
    pc_vec3 eye = pc_sub(c->back, pc_add(pc_scale(across, c->right), pc_scale(along, c->up)));
    pc_vec3 p = pc_sub(pc_scale(c->distance, c->back), pc_scale(w, eye)); /* from the centre */
    pc_vec3 v = pc_unit(eye), normal = {(double)n[0], (double)n[1], (double)n[2]};
    pc_vec3 r = pc_sub(pc_scale(2 * pc_dot(normal, v), normal), v);
    double b = pc_dot(p, r), far = sqrt(fmax(0, b * b - pc_dot(p, p) + radius * radius)) - b;
    pc_vec3 pole = {(double)s->light.pole[0], (double)s->light.pole[1], (double)s->light.pole[2]};
    *facing = (float)fabs(pc_dot(normal, v));
    return 0.5F * s->surface->stripes * (float)(1 + pc_dot(pc_madd(p, far, r), pole) / radius);
}

/* Black of a row of stripes, half black and half white each, on [at - width/2, at + width/2]. */
static float stripe_cover(float at, float width) {
    float low = at - 0.5F * width, high = at + 0.5F * width;
    float below = 0.5F * floorf(low) + pc_lesser(low - floorf(low), 0.5F);
    float above = 0.5F * floorf(high) + pc_lesser(high - floorf(high), 0.5F);
    return (above - below) / width;
}

/* How fast the stripes follow each other in a face. */
static void take_blur(facet *t, const shader *s) {
    float f[3], facing;
    const float *corner[3] = {t->a, t->b, t->c};
    for (int k = 0; k < 3; k++)
        f[k] =
            stripe_at(&facing, s, corner[k][0], corner[k][1], corner[k][2], s->normal + 3 * (size_t)t->v[k]);
    float bx = t->b[0] - t->a[0], by = t->b[1] - t->a[1], cx = t->c[0] - t->a[0], cy = t->c[1] - t->a[1];
    float fx = ((f[1] - f[0]) * cy - (f[2] - f[0]) * by) * t->inverse;
    float fy = ((f[2] - f[0]) * bx - (f[1] - f[0]) * cx) * t->inverse;
    t->blur = pc_lesser(pc_greater(fabsf(fx) + fabsf(fy), 1e-3F), 8);
}

static void take_facet(facet *t, const shader *s, pc_index face) {
    const pc_surface *f = s->surface;
    t->face = face;
    t->v = f->triangle + 3 * (size_t)face;
    t->a = s->screen + 3 * (size_t)t->v[0], t->b = s->screen + 3 * (size_t)t->v[1];
    t->c = s->screen + 3 * (size_t)t->v[2];
    float area = (t->b[0] - t->a[0]) * (t->c[1] - t->a[1]) - (t->b[1] - t->a[1]) * (t->c[0] - t->a[0]);
    t->inverse = area != 0 ? 1 / area : 0;
    if (f->flat > 0) flat_normal(t->normal, s, t);
    if (f->stripes > 0) take_blur(t, s);
}

/* Weights of the corners at a sample, corrected for perspective: depth + 1 grows as 1/distance. */
static void corner_weights(float w[3], const facet *t, float x, float y) {
    const float *a = t->a, *b = t->b, *c = t->c;
    w[1] = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) * t->inverse;
    w[2] = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) * t->inverse;
    w[1] = pc_lesser(pc_greater(w[1], 0), 1), w[2] = pc_lesser(pc_greater(w[2], 0), 1 - w[1]);
    w[0] = 1 - w[1] - w[2];
    w[0] *= a[2] + 1, w[1] *= b[2] + 1, w[2] *= c[2] + 1;
    float inverse = 1 / (w[0] + w[1] + w[2]);
    for (int k = 0; k < 3; k++)
        w[k] *= inverse;
}

/* Towards the rim of the model, where all stripes are narrower than a sample, only their mean. */
static pc_color striped(const shader *s, const facet *t, float x, float y, const float n[3]) {
    const size_t at = (size_t)y * (size_t)s->picture->columns + (size_t)x;
    float facing, where = stripe_at(&facing, s, x, y, s->picture->depth[at], n);
    float cover = stripe_cover(where, t->blur);
    return pc_color_mix(0xf6f5f1, 0x1b2733, 0.5F + (cover - 0.5F) * pc_lesser(1, 4 * facing));
}

static pc_color shaded(const shader *s, const facet *t, float x, float y, float shade) {
    const pc_surface *f = s->surface;
    float w[3];
    corner_weights(w, t, x, y);
    float n[3] = {0, 0, 0};
    for (int k = 0; k < 3 && f->flat < 1; k++) {
        const float *m = s->normal + 3 * (size_t)t->v[k];
        n[0] += w[k] * m[0], n[1] += w[k] * m[1], n[2] += w[k] * m[2];
    }
    if (f->flat > 0) {
        unit3(n);
        for (int k = 0; k < 3; k++)
            n[k] = (1 - f->flat) * n[k] + f->flat * t->normal[k];
    } else if (dot3(n, n) < 1e-6F) {
        flat_normal(n, s, t);
    }
    unit3(n);
    pc_color base = f->face_color ? f->face_color[t->face] : f->color;
    if (f->value) {
        float value = w[0] * f->value[t->v[0]] + w[1] * f->value[t->v[1]] + w[2] * f->value[t->v[2]];
        base = pc_colormap_at(f->map, (value - f->low) / (f->high - f->low));
    }
    if (f->stripes > 0) base = striped(s, t, x, y, n);
    return lit(s, base, n, shade);
}

static void shade_row(pc_picture *picture, const shader *s, const pc_index *owner, int y) {
    facet t = {.face = PC_NONE};
    size_t line = (size_t)y * (size_t)picture->columns;
    const float *shade = s->shade + (size_t)(y / picture->samples) * (size_t)picture->width;
    for (int x = s->pane->box[0]; x < s->pane->box[2]; x++) {
        pc_index face = owner[line + (size_t)x];
        if (face == PC_NONE) continue;
        if (face != t.face) take_facet(&t, s, face);
        picture->color[line + (size_t)x] =
            shaded(s, &t, (float)x + 0.5F, (float)y + 0.5F, shade[x / picture->samples]);
    }
}

/* Face normals summed over each n-gon. */
static pc_status make_owner_normals(pc_vec3 **out, pc_context *ctx, const pc_surface *surface) {
    pc_index count = 0;
    for (size_t f = 0; f < surface->face_count; f++)
        if (surface->face_owner[f] >= count) count = surface->face_owner[f] + 1;
    pc_status status = pc_new(out, ctx, count);
    if (status != PC_OK) return status;
    for (size_t f = 0; f < surface->face_count; f++) {
        pc_vec3 *sum = *out + surface->face_owner[f];
        *sum = pc_add(*sum, face_normal(surface->position, surface->triangle + 3 * f));
    }
    for (size_t i = 0; i < count; i++)
        (*out)[i] = pc_unit((*out)[i]);
    return PC_OK;
}

pc_status pc_surface_draw(pc_picture *picture, pc_context *ctx, const pc_surface *surface) {
    pc_status status;
    float *screen = NULL, *normal = NULL, *shade = NULL;
    pc_index *owner = NULL;
    pc_vec3 *owner_normal = NULL;
    PC_TRY(pc_new(&screen, ctx, 3 * (size_t)surface->vertex_count));
    PC_TRY(pc_new(&owner, ctx, (size_t)picture->columns * (size_t)picture->rows));
    PC_TRY(pc_new(&shade, ctx, (size_t)picture->width * (size_t)picture->height));
    if (!surface->normal && surface->flat < 1) {
        PC_TRY(pc_new(&normal, ctx, 3 * (size_t)surface->vertex_count));
        pc_surface_normals(normal, surface->position, surface->vertex_count, surface->triangle,
                           surface->face_count);
    }
    if (surface->face_owner) PC_TRY(make_owner_normals(&owner_normal, ctx, surface));
    shader s = {.surface = surface,
                .picture = picture,
                .screen = screen,
                .shade = shade,
                .normal = surface->normal ? surface->normal : normal,
                .owner_normal = owner_normal};
    make_tone(&s.tone);
    for (int k = 0; k < picture->pane_count; k++) {
        s.pane = &picture->pane[k];
        make_lights(&s.light, &s.pane->camera);
        pc_raster_project(screen, &s.pane->camera, surface->position, surface->vertex_count);
        PC_TRY(
            pc_raster_triangles(picture, ctx, owner, s.pane, screen, surface->triangle, surface->face_count));
        if (surface->cavity > 0) PC_TRY(pc_occlusion_make(shade, ctx, picture, s.pane));
#pragma omp parallel for schedule(dynamic, 16)
        for (int y = s.pane->box[1]; y < s.pane->box[3]; y++)
            shade_row(picture, &s, owner, y);
    }
done:
    pc_free(ctx, screen);
    pc_free(ctx, normal);
    pc_free(ctx, shade);
    pc_free(ctx, owner);
    pc_free(ctx, owner_normal);
    return status;
}
