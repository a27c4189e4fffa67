#include "step.h"
#include "decimal.h"
#include "file.h"
#include "memory.h"
#include <stdio.h>
#include <string.h>

/* Entities are numbered as they are written. The first failure stays and makes all later puts idle. */
typedef struct step {
    pc_writer writer;
    pc_status status;
    size_t entity; /* the last one */
    const pc_shell *shell;
    size_t *vertex; /* per vertex: its VERTEX_POINT */
    size_t *edge;   /* per edge: its EDGE_CURVE */
    size_t *face;   /* per face: its ADVANCED_FACE */
    size_t *brep;   /* per component: what the representation lists */
} step;

static void put(step *s, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void put(step *s, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (s->status == PC_OK) s->status = pc_writer_put(&s->writer, text, (size_t)length);
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
    if (s->status == PC_OK) s->status = pc_writer_put(&s->writer, out, at);
}

/* Begins the next entity and returns its number. */
static size_t begin(step *s) {
    put(s, "#%zu=", ++s->entity);
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
        put(s, "%s%d", i ? "," : "(", i == 0 || i + 1 == knots ? 4 : 1);
    put(s, ")");
}

static void put_knots(step *s, const double *knot, pc_index count) {
    for (pc_index i = 0; i < count; i++) {
        put(s, i ? "," : "(");
        put_real(s, knot[i]);
    }
    put(s, ")");
}

static void put_edge(step *s, pc_index e) {
    const pc_shell_edge *edge = s->shell->edge + e;
    size_t first = s->entity + 1;
    for (pc_index i = 0; i < edge->point_count; i++)
        (void)put_point(s, s->shell->point + 3 * (edge->point + i));
    size_t curve = begin(s);
    put(s, "B_SPLINE_CURVE_WITH_KNOTS('',3,(");
    for (pc_index i = 0; i < edge->point_count; i++)
        put(s, "%s#%zu", i ? "," : "", first + i);
    put(s, "),.UNSPECIFIED.,.F.,.F.,");
    put_multiplicities(s, edge->point_count - 2);
    put(s, ",");
    put_knots(s, s->shell->knot + edge->knot, edge->point_count - 2);
    put(s, ",.UNSPECIFIED.);\n");
    s->edge[e] = begin(s);
    put(s, "EDGE_CURVE('',#%zu,#%zu,#%zu,.T.);\n", s->vertex[edge->vertex[0]], s->vertex[edge->vertex[1]],
        curve);
}

static size_t put_surface(step *s, const pc_shell_face *face) {
    pc_index n = face->point_count[0], m = face->point_count[1];
    size_t first = s->entity + 1;
    for (size_t i = 0; i < (size_t)n * m; i++)
        (void)put_point(s, s->shell->point + 3 * (face->point + i));
    size_t surface = begin(s);
    put(s, "B_SPLINE_SURFACE_WITH_KNOTS('',3,3,(");
    for (pc_index i = 0; i < n; i++) {
        put(s, i ? ",(" : "(");
        for (pc_index j = 0; j < m; j++)
            put(s, "%s#%zu", j ? "," : "", first + i + (size_t)j * n);
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
    size_t surface = put_surface(s, face), first = s->entity + 1;
    for (size_t i = face->loop; i < face->loop + face->loop_count; i++) {
        pc_index directed = s->shell->loop[i];
        (void)begin(s);
        put(s, "ORIENTED_EDGE('',*,*,#%zu,%s);\n", s->edge[directed / 2], directed % 2 ? ".F." : ".T.");
    }
    size_t loop = begin(s);
    put(s, "EDGE_LOOP('',(");
    for (pc_index i = 0; i < face->loop_count; i++)
        put(s, "%s#%zu", i ? "," : "", first + i);
    put(s, "));\n");
    size_t bound = begin(s);
    put(s, "FACE_OUTER_BOUND('',#%zu,.T.);\n", loop);
    s->face[f] = begin(s);
    put(s, "ADVANCED_FACE('',(#%zu),#%zu,.T.);\n", bound, surface);
}

static void put_component(step *s, pc_index component, bool closed) {
    bool any = false;
    size_t shell = begin(s);
    put(s, "%s_SHELL('',(", closed ? "CLOSED" : "OPEN");
    for (pc_index f = 0; f < s->shell->face_count; f++) {
        if (s->shell->face[f].component != component) continue;
        put(s, "%s#%zu", any ? "," : "", s->face[f]);
        any = true;
    }
    put(s, "));\n");
    s->brep[component] = begin(s);
    if (closed)
        put(s, "MANIFOLD_SOLID_BREP('',#%zu);\n", shell);
    else
        put(s, "SHELL_BASED_SURFACE_MODEL('',(#%zu));\n", shell);
}

/* Units, and the uncertainty: exact up to rounding. Returns the context. */
static size_t put_context(step *s, double size) {
    size_t length = begin(s);
    put(s, "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n");
    size_t angle = begin(s);
    put(s, "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n");
    size_t solid = begin(s);
    put(s, "(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n");
    size_t uncertainty = begin(s);
    put(s, "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(");
    put_real(s, size > 0 ? 1e-8 * size : 1e-7);
    put(s, "),#%zu,'distance_accuracy_value','');\n", length);
    size_t context = begin(s);
    put(s,
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#%zu))"
        "GLOBAL_UNIT_ASSIGNED_CONTEXT((#%zu,#%zu,#%zu))REPRESENTATION_CONTEXT('',''));\n",
        uncertainty, length, angle, solid);
    return context;
}

static size_t put_frame(step *s) {
    const double zero[3] = {0, 0, 0};
    size_t origin = put_point(s, zero), z = begin(s);
    put(s, "DIRECTION('',(0.,0.,1.));\n");
    size_t x = begin(s);
    put(s, "DIRECTION('',(1.,0.,0.));\n");
    size_t frame = begin(s);
    put(s, "AXIS2_PLACEMENT_3D('',#%zu,#%zu,#%zu);\n", origin, z, x);
    return frame;
}

static void put_product(step *s, const char *name, size_t representation) {
    size_t application = begin(s);
    put(s, "APPLICATION_CONTEXT('core data for automotive mechanical design processes');\n");
    (void)begin(s);
    put(s, "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#%zu);\n",
        application);
    size_t context = begin(s);
    put(s, "PRODUCT_CONTEXT('',#%zu,'mechanical');\n", application);
    size_t product = begin(s);
    put(s, "PRODUCT('%s','%s','',(#%zu));\n", name, name, context);
    (void)begin(s);
    put(s, "PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#%zu));\n", product);
    size_t formation = begin(s);
    put(s, "PRODUCT_DEFINITION_FORMATION('','',#%zu);\n", product);
    size_t definition_context = begin(s);
    put(s, "PRODUCT_DEFINITION_CONTEXT('part definition',#%zu,'design');\n", application);
    size_t definition = begin(s);
    put(s, "PRODUCT_DEFINITION('design','',#%zu,#%zu);\n", formation, definition_context);
    size_t shape = begin(s);
    put(s, "PRODUCT_DEFINITION_SHAPE('','',#%zu);\n", definition);
    (void)begin(s);
    put(s, "SHAPE_DEFINITION_REPRESENTATION(#%zu,#%zu);\n", shape, representation);
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
    put(s,
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('B-spline surfaces of a T-spline'),'2;1');\n"
        "FILE_NAME('%s','',(''),(''),'percale','percale','');\n"
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n",
        name);
    for (pc_index v = 0; v < shell->vertex_count; v++) {
        size_t point = put_point(s, shell->vertex + 3 * (size_t)v);
        s->vertex[v] = begin(s);
        put(s, "VERTEX_POINT('',#%zu);\n", point);
    }
    for (pc_index e = 0; e < shell->edge_count; e++)
        put_edge(s, e);
    for (pc_index f = 0; f < shell->face_count; f++)
        put_face(s, f);
    for (pc_index c = 0; c < shell->component_count; c++)
        put_component(s, c, closed);
    size_t frame = put_frame(s), context = put_context(s, size), representation = begin(s);
    put(s, "%s_SHAPE_REPRESENTATION('',(#%zu", closed ? "ADVANCED_BREP" : "MANIFOLD_SURFACE", frame);
    for (pc_index c = 0; c < shell->component_count; c++)
        put(s, ",#%zu", s->brep[c]);
    put(s, "),#%zu);\n", context);
    put_product(s, name, representation);
    put(s, "ENDSEC;\nEND-ISO-10303-21;\n");
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
    PC_TRY(pc_new(&s.brep, ctx, shell->component_count));
    PC_TRY(pc_writer_open(&s.writer, ctx, path, force));
    put_all(&s, size, clean);
    PC_TRY(s.status);
    PC_TRY(pc_writer_commit(&s.writer));
done:
    if (status != PC_OK) pc_writer_abandon(&s.writer);
    pc_free(ctx, s.vertex);
    pc_free(ctx, s.edge);
    pc_free(ctx, s.face);
    pc_free(ctx, s.brep);
    return status;
}
