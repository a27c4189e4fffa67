/* What a fit minimises, as a linear system for the moves of its free control points: the weighted squares of
 * the distances to samples, and the bending of thin plates (digest C38, C39).
 *
 *   sum of weight |S(place) - target|^2 + fairness * sum over faces of the integral over [0,1]^2 of
 *   (|S_uu|^2 + 2 |S_uv|^2 + |S_vv|^2) / size,   u and v running from 0 to 1 across each face, size the side
 * of the square of as much area in knots.
 *
 * Both terms scale with the square of the model's size, so that the fairness has no unit. On an element the
 * first needs only 49 sums over its samples, because products of two Bernstein polynomials of degree 3 are
 * multiples of those of degree 6. */
#ifndef PC_ENERGY_H
#define PC_ENERGY_H

#include "device.h"
#include "system.h"
#include "tspline.h"

/* A point that the surface should have at a place. */
typedef struct pc_sample {
    pc_surface_place place;
    pc_vec3 target;
    double weight;
} pc_sample;

/* A system whose graph stays while samples and control points change. */
typedef struct pc_energy {
    const pc_tspline *spline; /* borrowed; its mesh and basis do not change */
    const float *stiffness;   /* per face: how many times as stiff it is; borrowed, NULL: once. Set before the
                                 first filling. */
    pc_index row_count;       /* free control points that have a function on the surface */
    pc_index *vertex;         /* per row, ascending */
    pc_index *row;            /* per vertex; PC_NONE where it stays where it is */
    pc_index element_count;   /* those under the functions of the rows */
    pc_index *element;        /* ascending */
    pc_index *local;          /* per element of the basis: its place in `element`, or PC_NONE */
    size_t *start;            /* per row: its uses */
    size_t *use;              /* places in basis->point, ascending in a row */
    pc_index *use_element;    /* per use, place in `element` */
    size_t *slot_start;       /* per row: its slots */
    uint16_t *slot;   /* per use and function on its element: which entry of the row; one of the two below */
    double plate[48]; /* integrals of products of Bernstein polynomials, of their first and second
                         derivatives */
    pc_system system;
    double *right; /* 3 per row: x, y, z */
    double *tally; /* 3 per listed element: sum of weight |S - target|^2, of the weights; bending */
    struct pc_energy_resident *resident; /* what stays on the device between fillings */
} pc_energy;
enum { PC_SLOT_DIAGONAL = 0xfffe, PC_SLOT_FIXED = 0xffff };

/* What one filling found. */
typedef struct pc_energy_facts {
    double square; /* sum of weight |S - target|^2 over the samples used, before they move anything */
    double weight;
    double bending; /* fairness times the bending */
} pc_energy_facts;

/* The graph. `free` tells which control points may move (per vertex, not 0; NULL: all). PC_E_NOMEM; PC_E_MESH
 * where there are too many couplings. */
pc_status pc_energy_make(pc_energy *energy, pc_context *ctx, const pc_tspline *spline, const uint8_t *free);
/* Values and right-hand sides for the moves from where the control points are; spline->bezier is up to date.
 * `samples` are sorted by element; those on elements that nothing free reaches are skipped. A row without
 * energy gets the diagonal 1. The same bytes for any number of threads. PC_E_NOMEM, PC_E_DEVICE. */
pc_status pc_energy_fill(pc_energy *energy, pc_energy_facts *facts, pc_context *ctx, pc_device *device,
                         const pc_sample *samples, size_t count, double fairness);
void pc_energy_free(pc_energy *energy, pc_context *ctx);

/* Inputs of both back ends. */
typedef struct pc_energy_work {
    const pc_sample *samples;
    const size_t *first; /* per element of the basis +1 */
    double fairness;
} pc_energy_work;
/* Local sums and rows by kernels/fit.cl; pc_energy_fill calls it. */
pc_status pc_energy_launch(pc_energy *energy, pc_context *ctx, pc_device *device, const pc_energy_work *work);
/* Frees what it has left on the device. */
void pc_energy_withdraw(pc_energy *energy, pc_context *ctx);
/* The factors of the bending's terms on an element. */
void pc_energy_bending(double factor[3], const pc_energy *energy, pc_index e, double fairness);

#endif
