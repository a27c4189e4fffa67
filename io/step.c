#include "step.h"
#include "memory.h"
#include "random.h"
#include "textout.h"
#include <string.h>

/* An edge in the parameters of a face: where the curve's parameter is 0, and along which side it runs. */
typedef struct trace {
    pc_index face; /* PC_NONE past a border */
    double origin[2];
    int way; /* 0..3: +s, +t, -s, -t */
} trace;

/* A line in the parameters of some face, which others may have too. */
typedef struct line {
    double origin[2];
    int way;
    size_t entity; /* 0: none yet */
} line;

enum { LINES = 4096 }; /* those met last */

/* Entities are numbered as they are written. */
typedef struct step {
    pc_textout out;
    size_t entity; /* the last one */
    const pc_shell *shell;
    size_t *vertex; /* per vertex: its VERTEX_POINT */
    size_t *edge;   /* per edge: its EDGE_CURVE */
    size_t *face;   /* per face: its surface, then its ADVANCED_FACE */
    size_t *point;  /* per face: the first of its control points */
    line *line;
    trace *trace;  /* per directed edge */
    size_t way[4]; /* VECTORs along the sides of the parameters' rectangle */
    size_t plane;  /* context of curves there */
    size_t *brep;  /* per component: what the representation lists */
} step;

static void put(step *s, const char *text) {
    pc_textout_text(&s->out, text, strlen(text));
}

static void put_reference(step *s, size_t entity) {
    put(s, "#");
    pc_textout_integer(&s->out, entity);
}

/* `count` of them: every `stride`-th from the first. */
static void put_references(step *s, size_t first, ptrdiff_t stride, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (i) put(s, ",");
        put_reference(s, (size_t)((ptrdiff_t)first + stride * (ptrdiff_t)i));
    }
}

/* Reals of STEP have a point, and an E. */
static void put_real(step *s, double x) {
    char text[PC_DECIMAL_SPACE + 2], out[PC_DECIMAL_SPACE + 4];
    size_t length = pc_decimal_write(text, x), at = 0, i = 0;
    bool point = memchr(text, '.', length) != NULL;
    for (; i < length; i++) {
        bool exponent = text[i] == 'e' || text[i] == 'E';
        if (exponent && !point) out[at++] = '.', point = true;
        out[at++] = exponent ? 'E' : text[i];
    }
    if (!point) out[at++] = '.';
    pc_textout_text(&s->out, out, at);
}

/* Begins the next entity and returns its number. */
static size_t begin(step *s) {
    put_reference(s, ++s->entity);
    put(s, "=");
    return s->entity;
}

static size_t put_point(step *s, const double *p) {
    size_t number = begin(s);
    put(s, "CARTESIAN_POINT('',(");
    for (int k = 0; k < 3; k++) {
        if (k) put(s, ",");
        put_real(s, p[k]);
    }
    put(s, "));\n");
    return number;
}

/* (4,1,...,1,4) */
static void put_multiplicities(step *s, pc_index knots) {
    for (pc_index i = 0; i < knots; i++)
        put(s, i == 0 ? "(4" : i + 1 == knots ? ",4" : ",1");
    put(s, ")");
}

static void put_knots(step *s, const double *knot, pc_index count) {
    for (pc_index i = 0; i < count; i++) {
        put(s, i ? "," : "(");
        put_real(s, knot[i]);
    }
    put(s, ")");
}

/* ---- Curves in the parameters ----
 * Readers that have none project every edge onto its surfaces, and now and then miss. */

static double span_of(const double *knot, pc_index point_count) {
    return knot[point_count - 3] - knot[0];
}

/* The loop runs around the rectangle of the face's parameters, counter-clockwise from its lower corner. */
static void trace_face(step *s, pc_index f) {
    const pc_shell *shell = s->shell;
    const pc_shell_face *face = shell->face + f;
    double low[2], size[2], along = 0;
    for (int k = 0; k < 2; k++) {
        low[k] = shell->knot[face->knot[k]];
        size[k] = span_of(shell->knot + face->knot[k], face->point_count[k]);
    }
    int side = 0;
    for (size_t i = face->loop; i < face->loop + face->loop_count; i++) {
        bool back = shell->loop[i] % 2;
        const pc_shell_edge *edge = shell->edge + shell->loop[i] / 2;
        const double *knot = shell->knot + edge->knot;
        double span = span_of(knot, edge->point_count);
        while (side < 3 && along + span / 2 > size[side & 1])
            along -= size[side++ & 1];
        double at[2] = {side == 1 ? size[0] : 0, side == 2 ? size[1] : 0}; /* where the loop's t is 0 */
        int d = side & 1;
        double run = side < 2 ? 1 : -1, begin = back ? along + span : along;
        at[d] = side < 2 ? begin : size[d] - begin;
        if (back) run = -run;
        trace *t = s->trace + shell->loop[i];
        *t = (trace){.face = f, .way = d + (run < 0 ? 2 : 0)};
        at[d] -= run * knot[0];
        for (int k = 0; k < 2; k++)
            t->origin[k] = low[k] + at[k];
        along += span;
    }
}

static void put_plane(step *s) {
    static const char *const way[4] = {"1.,0.", "0.,1.", "-1.,0.", "0.,-1."};
    for (int k = 0; k < 4; k++) {
        size_t direction = begin(s);
        pc_textout_put(&s->out, "DIRECTION('',(%s));\n", way[k]);
        s->way[k] = begin(s);
        pc_textout_put(&s->out, "VECTOR('',#%zu,1.);\n", direction);
    }
    s->plane = begin(s);
    pc_textout_put(&s->out, "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()"
                            "REPRESENTATION_CONTEXT('2D',''));\n");
}

/* The same lines are met again and again: most faces have parameters from 0 to 1. */
static size_t put_line(step *s, const trace *t) {
    uint64_t bits[2];
    memcpy(bits, t->origin, sizeof bits);
    line *l = s->line + pc_hash64(bits[0] ^ pc_hash64(bits[1] + (uint64_t)t->way)) % LINES;
    if (l->entity && l->way == t->way && l->origin[0] == t->origin[0] && l->origin[1] == t->origin[1])
        return l->entity;
    size_t point = begin(s);
    put(s, "CARTESIAN_POINT('',(");
    put_real(s, t->origin[0]);
    put(s, ",");
    put_real(s, t->origin[1]);
    put(s, "));\n");
    *l = (line){{t->origin[0], t->origin[1]}, t->way, begin(s)};
    pc_textout_put(&s->out, "LINE('',#%zu,#%zu);\n", point, s->way[t->way]);
    return l->entity;
}

static size_t put_trace(step *s, const trace *t) {
    size_t on = put_line(s, t), representation = begin(s);
    pc_textout_put(&s->out, "DEFINITIONAL_REPRESENTATION('',(#%zu),#%zu);\n", on, s->plane);
    size_t curve = begin(s);
    pc_textout_put(&s->out, "PCURVE('',#%zu,#%zu);\n", s->face[t->face], representation);
    return curve;
}

/* The curve with its traces on the surfaces beside it. */
static size_t put_surface_curve(step *s, pc_index e, size_t curve) {
    size_t on[2], count = 0;
    for (pc_index k = 0; k < 2; k++)
        if (s->trace[2 * e + k].face != PC_NONE) on[count++] = put_trace(s, s->trace + 2 * e + k);
    size_t surface_curve = begin(s);
    pc_textout_put(&s->out, "SURFACE_CURVE('',#%zu,(", curve);
    for (size_t k = 0; k < count; k++)
        pc_textout_put(&s->out, "%s#%zu", k ? "," : "", on[k]);
    pc_textout_put(&s->out, "),.CURVE_3D.);\n");
    return surface_curve;
}

static bool are_same(const double p[3], const double q[3]) {
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

/* Most edges are a whole side of a face, whose control points are theirs: the entity of the first one, and
 * how far it is to the next. */
static bool find_points(size_t *first, ptrdiff_t *stride, const step *s, pc_index e) {
    const pc_shell *shell = s->shell;
    const pc_shell_edge *edge = shell->edge + e;
    for (int k = 0; k < 4; k++) { /* both faces, both of the sides along which the edge may run */
        const trace *t = s->trace + 2 * (size_t)e + k / 2;
        if (t->face == PC_NONE) continue;
        const pc_shell_face *face = shell->face + t->face;
        const ptrdiff_t n = face->point_count[0], count = edge->point_count, d = t->way & 1;
        const ptrdiff_t last = (ptrdiff_t)face->point_count[1 - d] - 1;
        if (count != (ptrdiff_t)face->point_count[d]) continue;
        ptrdiff_t at = k % 2 ? last * (d ? 1 : n) : 0, next = d ? n : 1, i = 0;
        if (t->way >= 2) at += next * (count - 1), next = -next;
        while (i < count && are_same(shell->point + 3 * (edge->point + (size_t)i),
                                     shell->point + 3 * (face->point + (size_t)(at + i * next))))
            i++;
        if (i < count) continue;
        *first = s->point[t->face] + (size_t)at, *stride = next;
        return true;
    }
    return false;
}

static void put_edge(step *s, pc_index e) {
    const pc_shell_edge *edge = s->shell->edge + e;
    size_t first = s->entity + 1;
    ptrdiff_t stride = 1;
    const bool shared = find_points(&first, &stride, s, e);
    for (pc_index i = 0; i < edge->point_count && !shared; i++)
        (void)put_point(s, s->shell->point + 3 * (edge->point + i));
    size_t curve = begin(s);
    put(s, "B_SPLINE_CURVE_WITH_KNOTS('',3,(");
    put_references(s, first, stride, edge->point_count);
    put(s, "),.UNSPECIFIED.,.F.,.F.,");
    put_multiplicities(s, edge->point_count - 2);
    put(s, ",");
    put_knots(s, s->shell->knot + edge->knot, edge->point_count - 2);
    pc_textout_put(&s->out, ",.UNSPECIFIED.);\n");
    curve = put_surface_curve(s, e, curve);
    s->edge[e] = begin(s);
    pc_textout_put(&s->out, "EDGE_CURVE('',#%zu,#%zu,#%zu,.T.);\n", s->vertex[edge->vertex[0]],
                   s->vertex[edge->vertex[1]], curve);
}

static size_t put_surface(step *s, pc_index f) {
    const pc_shell_face *face = s->shell->face + f;
    pc_index n = face->point_count[0], m = face->point_count[1];
    s->point[f] = s->entity + 1;
    for (size_t i = 0; i < (size_t)n * m; i++)
        (void)put_point(s, s->shell->point + 3 * (face->point + i));
    size_t surface = begin(s);
    put(s, "B_SPLINE_SURFACE_WITH_KNOTS('',3,3,(");
    for (pc_index i = 0; i < n; i++) {
        put(s, i ? ",(" : "(");
        put_references(s, s->point[f] + i, (ptrdiff_t)n, m);
        put(s, ")");
    }
    put(s, "),.UNSPECIFIED.,.F.,.F.,.F.,");
    put_multiplicities(s, n - 2);
    put(s, ",");
    put_multiplicities(s, m - 2);
    put(s, ",");
    put_knots(s, s->shell->knot + face->knot[0], n - 2);
    put(s, ",");
    put_knots(s, s->shell->knot + face->knot[1], m - 2);
    put(s, ",.UNSPECIFIED.);\n");
    return surface;
}

static void put_face(step *s, pc_index f) {
    const pc_shell_face *face = s->shell->face + f;
    size_t surface = s->face[f], first = s->entity + 1;
    for (size_t i = face->loop; i < face->loop + face->loop_count; i++) {
        pc_index directed = s->shell->loop[i];
        (void)begin(s);
        pc_textout_put(&s->out, "ORIENTED_EDGE('',*,*,#%zu,%s);\n", s->edge[directed / 2],
                       directed % 2 ? ".F." : ".T.");
    }
    size_t loop = begin(s);
    put(s, "EDGE_LOOP('',(");
    put_references(s, first, 1, face->loop_count);
    put(s, "));\n");
    size_t bound = begin(s);
    pc_textout_put(&s->out, "FACE_OUTER_BOUND('',#%zu,.T.);\n", loop);
    s->face[f] = begin(s);
    pc_textout_put(&s->out, "ADVANCED_FACE('',(#%zu),#%zu,.T.);\n", bound, surface);
}

static void put_component(step *s, pc_index component, bool closed) {
    bool any = false;
    size_t shell = begin(s);
    pc_textout_put(&s->out, "%s_SHELL('',(", closed ? "CLOSED" : "OPEN");
    for (pc_index f = 0; f < s->shell->face_count; f++) {
        if (s->shell->face[f].component != component) continue;
        pc_textout_put(&s->out, "%s#%zu", any ? "," : "", s->face[f]);
        any = true;
    }
    pc_textout_put(&s->out, "));\n");
    s->brep[component] = begin(s);
    if (closed)
        pc_textout_put(&s->out, "MANIFOLD_SOLID_BREP('',#%zu);\n", shell);
    else
        pc_textout_put(&s->out, "SHELL_BASED_SURFACE_MODEL('',(#%zu));\n", shell);
}

/* Units, and the uncertainty: exact up to rounding. Returns the context. */
static size_t put_context(step *s, double size) {
    size_t length = begin(s);
    pc_textout_put(&s->out, "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n");
    size_t angle = begin(s);
    pc_textout_put(&s->out, "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n");
    size_t solid = begin(s);
    pc_textout_put(&s->out, "(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n");
    size_t uncertainty = begin(s);
    pc_textout_put(&s->out, "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(");
    put_real(s, size > 0 ? 1e-8 * size : 1e-7);
    pc_textout_put(&s->out, "),#%zu,'distance_accuracy_value','');\n", length);
    size_t context = begin(s);
    pc_textout_put(&s->out,
                   "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#%zu))"
                   "GLOBAL_UNIT_ASSIGNED_CONTEXT((#%zu,#%zu,#%zu))REPRESENTATION_CONTEXT('',''));\n",
                   uncertainty, length, angle, solid);
    return context;
}

static size_t put_frame(step *s) {
    const double zero[3] = {0, 0, 0};
    size_t origin = put_point(s, zero), z = begin(s);
    pc_textout_put(&s->out, "DIRECTION('',(0.,0.,1.));\n");
    size_t x = begin(s);
    pc_textout_put(&s->out, "DIRECTION('',(1.,0.,0.));\n");
    size_t frame = begin(s);
    pc_textout_put(&s->out, "AXIS2_PLACEMENT_3D('',#%zu,#%zu,#%zu);\n", origin, z, x);
    return frame;
}

static void put_product(step *s, const char *name, size_t representation) {
    size_t application = begin(s);
    pc_textout_put(&s->out, "APPLICATION_CONTEXT('core data for automotive mechanical design processes');\n");
    (void)begin(s);
    pc_textout_put(
        &s->out, "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#%zu);\n",
        application);
    size_t context = begin(s);
    pc_textout_put(&s->out, "PRODUCT_CONTEXT('',#%zu,'mechanical');\n", application);
    size_t product = begin(s);
    pc_textout_put(&s->out, "PRODUCT('%s','%s','',(#%zu));\n", name, name, context);
    (void)begin(s);
    pc_textout_put(&s->out, "PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#%zu));\n", product);
    size_t formation = begin(s);
    pc_textout_put(&s->out, "PRODUCT_DEFINITION_FORMATION('','',#%zu);\n", product);
    size_t definition_context = begin(s);
    pc_textout_put(&s->out, "PRODUCT_DEFINITION_CONTEXT('part definition',#%zu,'design');\n", application);
    size_t definition = begin(s);
    pc_textout_put(&s->out, "PRODUCT_DEFINITION('design','',#%zu,#%zu);\n", formation, definition_context);
    size_t shape = begin(s);
    pc_textout_put(&s->out, "PRODUCT_DEFINITION_SHAPE('','',#%zu);\n", definition);
    (void)begin(s);
    pc_textout_put(&s->out, "SHAPE_DEFINITION_REPRESENTATION(#%zu,#%zu);\n", shape, representation);
}

/* Letters, digits and a few signs; others have a meaning in STEP, or none. */
static void clean_name(char clean[128], const char *name) {
    size_t at = 0;
    for (; *name && at < 127; name++) {
        bool plain = (*name >= 'a' && *name <= 'z') || (*name >= 'A' && *name <= 'Z') ||
                     (*name >= '0' && *name <= '9') || strchr(" ._-+()", *name);
        clean[at++] = plain ? *name : '_';
    }
    clean[at] = 0;
}

static void put_all(step *s, double size, const char *name) {
    const pc_shell *shell = s->shell;
    bool closed = shell->border_count == 0;
    pc_textout_put(&s->out,
                   "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('B-spline surfaces of a T-spline'),'2;1');\n"
                   "FILE_NAME('%s','',(''),(''),'percale','percale','');\n"
                   "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n",
                   name);
    for (pc_index v = 0; v < shell->vertex_count; v++) {
        size_t point = put_point(s, shell->vertex + 3 * (size_t)v);
        s->vertex[v] = begin(s);
        pc_textout_put(&s->out, "VERTEX_POINT('',#%zu);\n", point);
    }
    put_plane(s);
    for (pc_index f = 0; f < shell->face_count; f++) {
        s->face[f] = put_surface(s, f);
        trace_face(s, f);
    }
    for (pc_index e = 0; e < shell->edge_count; e++)
        put_edge(s, e);
    for (pc_index f = 0; f < shell->face_count; f++)
        put_face(s, f);
    for (pc_index c = 0; c < shell->component_count; c++)
        put_component(s, c, closed);
    size_t frame = put_frame(s), context = put_context(s, size), representation = begin(s);
    pc_textout_put(&s->out, "%s_SHAPE_REPRESENTATION('',(#%zu", closed ? "ADVANCED_BREP" : "MANIFOLD_SURFACE",
                   frame);
    for (pc_index c = 0; c < shell->component_count; c++)
        pc_textout_put(&s->out, ",#%zu", s->brep[c]);
    pc_textout_put(&s->out, "),#%zu);\n", context);
    put_product(s, name, representation);
    pc_textout_put(&s->out, "ENDSEC;\nEND-ISO-10303-21;\n");
}

pc_status pc_step_write(pc_context *ctx, const pc_shell *shell, double size, const char *name,
                        const char *path, bool force) {
    pc_status status = PC_OK;
    step s = {.shell = shell};
    char clean[128];
    clean_name(clean, name);
    PC_TRY(pc_new(&s.vertex, ctx, shell->vertex_count));
    PC_TRY(pc_new(&s.edge, ctx, shell->edge_count));
    PC_TRY(pc_new(&s.face, ctx, shell->face_count));
    PC_TRY(pc_new(&s.point, ctx, shell->face_count));
    PC_TRY(pc_new(&s.line, ctx, LINES));
    PC_TRY(pc_new(&s.trace, ctx, 2 * (size_t)shell->edge_count));
    for (size_t i = 0; i < 2 * (size_t)shell->edge_count; i++)
        s.trace[i].face = PC_NONE;
    PC_TRY(pc_new(&s.brep, ctx, shell->component_count));
    PC_TRY(pc_textout_open(&s.out, ctx, path, force));
    put_all(&s, size, clean);
done:
    pc_free(ctx, s.vertex);
    pc_free(ctx, s.edge);
    pc_free(ctx, s.face);
    pc_free(ctx, s.point);
    pc_free(ctx, s.line);
    pc_free(ctx, s.trace);
    pc_free(ctx, s.brep);
    return pc_textout_close(&s.out, status);
}
