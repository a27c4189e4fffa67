#include "surface.h"
#include "memory.h"
#include "occlusion.h"
#include "pick.h"
#include "raster.h"
#include <string.h>

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
    float slope[2];         /* stripes from one sample to the next, right and down; where it has any */
} facet;

typedef struct shader {
    const pc_surface *surface;
    const pc_picture *picture;
    const pc_pane *pane;
    const float *screen, *normal, *shade;
    const float *stripe; /* per vertex, where the surface has stripes */
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

/* How a place on the surface is lit. */
typedef struct lighting {
    float light, gloss;
    bool behind; /* the back of a face is seen */
} lighting;

static lighting light_at(const shader *s, const float normal[3], float shade) {
    lighting l;
    float facing = dot3(normal, s->light.back), sign = facing < 0 ? -1.0F : 1.0F;
    const float n[3] = {sign * normal[0], sign * normal[1], sign * normal[2]};
    l.behind = facing < 0;
    l.light = light_on(&l.gloss, &s->light, n, sign * facing);
    l.light += s->surface->even * (1 - l.light);
    float dark = shade < 0 ? shade : 0.35F * shade;
    l.light *= pc_greater(0.25F, pc_lesser(1.25F, 1 + 0.62F * s->surface->cavity * dark));
    if (shade < 0) l.gloss *= pc_greater(0, 1 + shade);
    if (l.behind) l.light *= 0.8F, l.gloss = 0;
    return l;
}

static pc_color lit(const shader *s, pc_color base, const lighting *l) {
    if (l->behind) base = pc_color_mix(base, 0x8a6f5c, 0.45F);
    pc_color out = 0;
    for (int k = 0; k < 3; k++) {
        float v = s->tone.linear[pc_color_channel(base, k)] * l->light + l->gloss;
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

static pc_status make_stripes(float **out, pc_context *ctx, const shader *s) {
    pc_status status = *out ? PC_OK : pc_new(out, ctx, s->surface->vertex_count);
    if (status != PC_OK) return status;
#pragma omp parallel for schedule(static)
    for (size_t v = 0; v < s->surface->vertex_count; v++) {
        const float *p = s->screen + 3 * v;
        float facing;
        (*out)[v] = stripe_at(&facing, s, p[0], p[1], p[2], s->normal + 3 * v);
    }
    return PC_OK;
}

/* How fast the stripes follow each other in a face. */
static void take_slope(facet *t, const shader *s) {
    const float f0 = s->stripe[t->v[0]], f1 = s->stripe[t->v[1]] - f0, f2 = s->stripe[t->v[2]] - f0;
    float bx = t->b[0] - t->a[0], by = t->b[1] - t->a[1], cx = t->c[0] - t->a[0], cy = t->c[1] - t->a[1];
    t->slope[0] = (f1 * cy - f2 * by) * t->inverse, t->slope[1] = (f2 * bx - f1 * cx) * t->inverse;
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
    if (f->stripes > 0) take_slope(t, s);
}

/* Weights of the corners at a place, corrected for perspective: depth + 1 grows as 1/distance. */
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

/* The normal and the color inside a face, at corners' weights. */
static void normal_at(float n[3], const shader *s, const facet *t, const float w[3]) {
    const float flat = s->surface->flat;
    n[0] = n[1] = n[2] = 0;
    for (int k = 0; k < 3 && flat < 1; k++) {
        const float *m = s->normal + 3 * (size_t)t->v[k];
        n[0] += w[k] * m[0], n[1] += w[k] * m[1], n[2] += w[k] * m[2];
    }
    if (flat > 0) {
        unit3(n);
        for (int k = 0; k < 3; k++)
            n[k] = (1 - flat) * n[k] + flat * t->normal[k];
    } else if (dot3(n, n) < 1e-6F) {
        flat_normal(n, s, t);
    }
    unit3(n);
}

static pc_color color_at(const shader *s, const facet *t, const float w[3]) {
    const pc_surface *f = s->surface;
    if (!f->value) return f->face_color ? f->face_color[t->face] : f->color;
    float value = w[0] * f->value[t->v[0]] + w[1] * f->value[t->v[1]] + w[2] * f->value[t->v[2]];
    return pc_colormap_at(f->map, (value - f->low) / (f->high - f->low));
}

enum { MOST_SAMPLES = 16 };

/* Samples of one pixel. */
typedef struct samples {
    int count;
    int x[MOST_SAMPLES], y[MOST_SAMPLES];
    pc_index face[MOST_SAMPLES]; /* PC_NONE once it has its color */
} samples;

/* Stripes change fast: every sample has its own, the slope away from the middle. Towards the rim of the
 * model, where all stripes are narrower than a sample, only their mean. */
static void color_stripes(pc_color *color, const shader *s, const facet *t, const samples *p,
                          const float middle[3], const float n[3], const lighting *l) {
    const float *slope = t->slope;
    float facing, where = stripe_at(&facing, s, middle[0], middle[1], middle[2], n);
    float blur = pc_lesser(pc_greater(fabsf(slope[0]) + fabsf(slope[1]), 1e-3F), 8);
    for (int k = 0; k < p->count; k++) {
        float dx = (float)p->x[k] + 0.5F - middle[0], dy = (float)p->y[k] + 0.5F - middle[1];
        float cover = stripe_cover(where + pc_greater(-8, pc_lesser(8, slope[0] * dx + slope[1] * dy)), blur);
        pc_color base = pc_color_mix(0xf6f5f1, 0x1b2733, 0.5F + (cover - 0.5F) * pc_lesser(1, 4 * facing));
        color[(size_t)p->y[k] * (size_t)s->picture->columns + (size_t)p->x[k]] = lit(s, base, l);
    }
}

/* Samples on one smooth piece of the surface share the light at their middle, and the color where it is no
 * stripe: nobody sees the difference, and it is four times as fast. */
static void color_samples(pc_color *color, const shader *s, const facet *t, const samples *p, float shade) {
    float w[3], n[3], middle[3] = {0, 0, 0};
    const float part = 1 / (float)p->count;
    const size_t columns = (size_t)s->picture->columns;
    for (int k = 0; k < p->count; k++) {
        middle[0] += part * ((float)p->x[k] + 0.5F), middle[1] += part * ((float)p->y[k] + 0.5F);
        middle[2] += part * s->picture->depth[(size_t)p->y[k] * columns + (size_t)p->x[k]];
    }
    corner_weights(w, t, middle[0], middle[1]);
    normal_at(n, s, t, w);
    const lighting l = light_at(s, n, shade);
    if (s->surface->stripes > 0) {
        color_stripes(color, s, t, p, middle, n, &l);
        return;
    }
    const pc_color c = lit(s, color_at(s, t, w), &l);
    for (int k = 0; k < p->count; k++)
        color[(size_t)p->y[k] * columns + (size_t)p->x[k]] = c;
}

/* Whether a face goes on as the facet does where they meet: the same color, and normals that are its own or
 * those of common vertices. */
static bool goes_on(const shader *s, const facet *t, pc_index face) {
    const pc_surface *f = s->surface;
    const pc_index *v = f->triangle + 3 * (size_t)face, *u = t->v;
    if (f->face_color && f->face_color[face] != f->face_color[t->face]) return false;
    if (f->flat > 0 && !(f->face_owner && f->face_owner[face] == f->face_owner[t->face])) return false;
    return v[0] == u[0] || v[0] == u[1] || v[0] == u[2] || v[1] == u[0] || v[1] == u[1] || v[1] == u[2] ||
           v[2] == u[0] || v[2] == u[1] || v[2] == u[2];
}

/* What a pixel shows of the pane and of the surface. */
static inline void take_pixel(samples *p, const shader *s, const pc_index *owner, int x, int y) {
    const int *box = s->pane->box, n = s->picture->samples;
    const int x0 = x * n > box[0] ? x * n : box[0], x1 = (x + 1) * n < box[2] ? (x + 1) * n : box[2];
    const int y0 = y * n > box[1] ? y * n : box[1], y1 = (y + 1) * n < box[3] ? (y + 1) * n : box[3];
    p->count = 0;
    for (int j = y0; j < y1; j++)
        for (int i = x0; i < x1; i++) {
            const pc_index face = owner[(size_t)j * (size_t)s->picture->columns + (size_t)i];
            if (face == PC_NONE) continue;
            p->x[p->count] = i, p->y[p->count] = j, p->face[p->count++] = face;
        }
}

static void shade_pixel(pc_color *color, const shader *s, facet *t, samples *p, float shade) {
    for (int first = 0; first < p->count; first++) {
        if (p->face[first] == PC_NONE) continue;
        if (p->face[first] != t->face) take_facet(t, s, p->face[first]);
        samples same;
        same.count = 0;
        for (int k = first; k < p->count; k++) {
            if (p->face[k] != t->face && (p->face[k] == PC_NONE || !goes_on(s, t, p->face[k]))) continue;
            same.x[same.count] = p->x[k], same.y[same.count++] = p->y[k];
            p->face[k] = PC_NONE;
        }
        color_samples(color, s, t, &same, shade);
    }
}

/* Most of a picture is background. */
static bool is_empty(const pc_index *owner, size_t columns, int x0, int x1, int y0, int y1) {
    pc_index all = PC_NONE;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            all &= owner[(size_t)y * columns + (size_t)x];
    return all == PC_NONE;
}

/* One row of pixels. */
static void shade_row(pc_picture *picture, const shader *s, int y) {
    enum { BLOCK = 16 };
    const int n = picture->samples, *box = s->pane->box, end = (box[2] + n - 1) / n;
    const int y0 = y * n > box[1] ? y * n : box[1], y1 = (y + 1) * n < box[3] ? (y + 1) * n : box[3];
    const float *shade = s->shade + (size_t)y * (size_t)picture->width;
    facet t = {.face = PC_NONE};
    for (int x0 = box[0] / n; x0 < end; x0 += BLOCK) {
        const int x1 = x0 + BLOCK < end ? x0 + BLOCK : end;
        const int from = x0 * n > box[0] ? x0 * n : box[0], to = x1 * n < box[2] ? x1 * n : box[2];
        if (is_empty(picture->owner, (size_t)picture->columns, from, to, y0, y1)) continue;
        for (int x = x0; x < x1; x++) {
            samples p;
            take_pixel(&p, s, picture->owner, x, y);
            if (p.count > 0) shade_pixel(picture->color, s, &t, &p, shade[x]);
        }
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

/* Kept from surface to surface: fresh memory of that size takes longer than much of the drawing. */
static pc_status make_room(pc_picture *picture, pc_context *ctx) {
    const size_t pixels = (size_t)picture->width * (size_t)picture->height;
    pc_status status = PC_OK;
    if (!picture->owner)
        PC_TRY(pc_new(&picture->owner, ctx, (size_t)picture->columns * (size_t)picture->rows));
    if (!picture->shade) PC_TRY(pc_new(&picture->shade, ctx, pixels));
    memset(picture->shade, 0, pixels * sizeof(*picture->shade));
done:
    return status;
}

pc_status pc_surface_draw(pc_picture *picture, pc_context *ctx, const pc_surface *surface) {
    pc_status status;
    float *screen = NULL, *normal = NULL, *stripe = NULL;
    pc_vec3 *owner_normal = NULL;
    PC_TRY(pc_new(&screen, ctx, 3 * (size_t)surface->vertex_count));
    PC_TRY(make_room(picture, ctx));
    if (!surface->normal && surface->flat < 1) {
        PC_TRY(pc_new(&normal, ctx, 3 * (size_t)surface->vertex_count));
        pc_surface_normals(normal, surface->position, surface->vertex_count, surface->triangle,
                           surface->face_count);
    }
    if (surface->face_owner) PC_TRY(make_owner_normals(&owner_normal, ctx, surface));
    shader s = {.surface = surface,
                .picture = picture,
                .screen = screen,
                .shade = picture->shade,
                .normal = surface->normal ? surface->normal : normal,
                .owner_normal = owner_normal};
    make_tone(&s.tone);
    for (int k = 0; k < picture->pane_count; k++) {
        s.pane = &picture->pane[k];
        make_lights(&s.light, &s.pane->camera);
        pc_raster_project(screen, &s.pane->camera, surface->position, surface->vertex_count);
        PC_TRY(pc_raster_triangles(picture, ctx, picture->owner, s.pane, screen, surface->triangle,
                                   surface->face_count));
        if (surface->cavity > 0) PC_TRY(pc_occlusion_make(picture->shade, ctx, picture, s.pane));
        if (surface->stripes > 0) PC_TRY(make_stripes(&stripe, ctx, &s));
        s.stripe = stripe;
#pragma omp parallel for schedule(dynamic, 8)
        for (int y = s.pane->box[1] / picture->samples;
             y < (s.pane->box[3] + picture->samples - 1) / picture->samples; y++)
            shade_row(picture, &s, y);
    }
done:
    pc_free(ctx, screen);
    pc_free(ctx, normal);
    pc_free(ctx, stripe);
    pc_free(ctx, owner_normal);
    return status;
}
