#include "ray.h"

static const pc_ray ended = {.way = PC_RAY_ENDED, .half = PC_NONE};

/* From the corner or side of the face of h at the tail of h, half-edges in a straight row: a flat corner is
 * two quarters wide. */
static int quarters(const pc_tmesh *mesh, pc_index h) {
    return pc_thalf_turns(mesh, h) ? 1 : 2;
}

/* Two quarters counter-clockwise from half-edge h around its tail; false where that is past the rim. */
static bool opposite_ccw(pc_ray *ray, const pc_tmesh *mesh, pc_index h) {
    int turned = 0;
    while (turned < 2) {
        if (mesh->half[h].face == PC_NONE) return false;
        int by = quarters(mesh, h);
        if (turned + by > 2) { /* the middle of a flat corner */
            *ray = (pc_ray){.way = PC_RAY_ACROSS, .half = h};
            return true;
        }
        turned += by;
        h = pc_thalf_ccw(mesh, h);
    }
    *ray = (pc_ray){.way = PC_RAY_ALONG, .half = h};
    return true;
}

static bool opposite_cw(pc_ray *ray, const pc_tmesh *mesh, pc_index h) {
    int turned = 0;
    while (turned < 2) {
        h = pc_thalf_cw(mesh, h);
        if (mesh->half[h].face == PC_NONE) return false;
        int by = quarters(mesh, h);
        if (turned + by > 2) {
            *ray = (pc_ray){.way = PC_RAY_ACROSS, .half = h};
            return true;
        }
        turned += by;
    }
    *ray = (pc_ray){.way = PC_RAY_ALONG, .half = h};
    return true;
}

pc_ray pc_ray_behind(const pc_tmesh *mesh, pc_index h) {
    pc_ray ray = ended;
    pc_index back = mesh->half[h].twin;
    if (!mesh->vertex[mesh->half[back].tail].extraordinary && !opposite_ccw(&ray, mesh, back))
        (void)opposite_cw(&ray, mesh, back);
    ray.last = mesh->half[h].interval;
    return ray;
}

/* Across the face of ray->half; ends on the opposite side, at a vertex or inside of a half-edge. */
static double cross(pc_ray *ray, const pc_tmesh *mesh) {
    const pc_thalf *e = mesh->half + ray->half;
    if (e->face == PC_NONE) {
        double last = ray->last;
        *ray = ended;
        ray->last = last;
        return last;
    }
    const double *size = mesh->face[e->face].size;
    double height = size[(e->side + 1) & 1], target = size[e->side & 1] - (e->along + ray->offset);
    int opposite = (e->side + 2) & 3;
    pc_index h = e->next;
    while (mesh->half[h].side != opposite || mesh->half[h].along + mesh->half[h].interval <= target)
        h = mesh->half[h].next;
    const pc_thalf *far = mesh->half + h;
    if (far->along < target) {
        *ray = (pc_ray){PC_RAY_ACROSS, far->twin, far->along + far->interval - target, height};
        return height;
    }
    pc_index beyond = pc_thalf_cw(mesh, h); /* the vertex is flat here: a quarter clockwise goes on */
    *ray = ended;
    if (mesh->half[far->twin].face != PC_NONE)
        *ray = (pc_ray){pc_thalf_turns(mesh, beyond) ? PC_RAY_ALONG : PC_RAY_ACROSS, beyond, 0, 0};
    ray->last = height;
    return height;
}

double pc_ray_step(pc_ray *ray, const pc_tmesh *mesh) {
    if (ray->way == PC_RAY_ENDED) return ray->last;
    if (ray->way == PC_RAY_ACROSS) return cross(ray, mesh);
    double interval = mesh->half[ray->half].interval;
    *ray = pc_ray_behind(mesh, ray->half);
    return interval;
}

void pc_star_make(pc_star *star, const pc_tmesh *mesh, pc_index v) {
    pc_index h = mesh->vertex[v].out;
    for (int d = 0; d < 4; d++)
        star->ray[d] = ended;
    for (int d = 0; d < 4;) {
        star->ray[d] = (pc_ray){.way = PC_RAY_ALONG, .half = h};
        if (mesh->half[h].face == PC_NONE) break; /* the other end of the rim */
        if (quarters(mesh, h) == 2) {
            if (d < 3) star->ray[d + 1] = (pc_ray){.way = PC_RAY_ACROSS, .half = h};
            d++;
        }
        d++;
        h = pc_thalf_ccw(mesh, h);
    }
}

/* Knots to both sides of 0 along two opposite rays. */
static void knots_along(double knots[5], const pc_tmesh *mesh, pc_ray plus, pc_ray minus) {
    double first = 0;
    if (plus.way != PC_RAY_ENDED) {
        first = pc_ray_step(&plus, mesh);
        if (minus.way == PC_RAY_ENDED) minus.last = first;
        knots[1] = -pc_ray_step(&minus, mesh);
    } else {
        knots[1] = -pc_ray_step(&minus, mesh);
        first = plus.last = -knots[1];
    }
    knots[0] = knots[1] - pc_ray_step(&minus, mesh);
    knots[2] = 0;
    knots[3] = first;
    knots[4] = first + pc_ray_step(&plus, mesh);
}

void pc_star_knots(double s[5], double t[5], const pc_tmesh *mesh, const pc_star *star) {
    knots_along(s, mesh, star->ray[0], star->ray[2]);
    knots_along(t, mesh, star->ray[1], star->ray[3]);
}

void pc_sector_knots(double s[5], double t[5], const pc_tmesh *mesh, pc_index h) {
    const pc_index spoke[4] = {h, pc_thalf_ccw(mesh, h), pc_thalf_ccw(mesh, pc_thalf_ccw(mesh, h)),
                               pc_thalf_cw(mesh, h)};
    double first[4], both[4];
    for (int d = 0; d < 4; d++) {
        pc_ray ray = {.way = PC_RAY_ALONG, .half = spoke[d]};
        first[d] = pc_ray_step(&ray, mesh);
        both[d] = first[d] + pc_ray_step(&ray, mesh);
    }
    s[0] = -both[2], s[1] = -first[2], s[2] = 0, s[3] = first[0], s[4] = both[0];
    t[0] = -both[3], t[1] = -first[3], t[2] = 0, t[3] = first[1], t[4] = both[1];
}
