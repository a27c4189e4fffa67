#include "gismo.h"
#include "memory.h"
#include "textout.h"
#include <string.h>

/* Sides are numbered 4*face + k, k counter-clockwise from t = low. */
typedef struct sides {
    const pc_shell *shell;
    pc_index *of_edge; /* per directed edge: the side that runs it; PC_NONE past a border */
    pc_index *length;  /* per side: edges along it */
    pc_index *beyond;  /* per side: the one that it meets from end to end; PC_NONE; BORDER */
} sides;

enum { WEST = 1, EAST, SOUTH, NORTH };
#define BORDER (PC_NONE - 1)
#define UNSEEN (PC_NONE - 2)

static double span_of(const double *knot, pc_index point_count) {
    return knot[point_count - 3] - knot[0];
}

/* Which side each edge of the loop lies on: the loop runs around the rectangle from its corner (low, low). */
static void walk_loop(sides *s, pc_index f) {
    const pc_shell *shell = s->shell;
    const pc_shell_face *face = shell->face + f;
    double end[4], along = 0;
    for (int k = 0; k < 4; k++)
        end[k] = (k ? end[k - 1] : 0) + span_of(shell->knot + face->knot[k & 1], face->point_count[k & 1]);
    for (size_t i = face->loop; i < face->loop + face->loop_count; i++) {
        const pc_shell_edge *edge = shell->edge + shell->loop[i] / 2;
        double span = span_of(shell->knot + edge->knot, edge->point_count);
        pc_index k = 0;
        while (k < 3 && along + span / 2 > end[k])
            k++;
        s->of_edge[shell->loop[i]] = 4 * f + k;
        s->length[4 * f + k]++;
        along += span;
    }
}

static void match_sides(sides *s) {
    const pc_shell *shell = s->shell;
    for (pc_index i = 0; i < 4 * shell->face_count; i++)
        s->beyond[i] = UNSEEN;
    for (pc_index f = 0; f < shell->face_count; f++)
        for (size_t i = shell->face[f].loop; i < shell->face[f].loop + shell->face[f].loop_count; i++) {
            pc_index side = s->of_edge[shell->loop[i]], other = s->of_edge[shell->loop[i] ^ 1];
            pc_index *beyond = s->beyond + side;
            if (other == PC_NONE)
                other = BORDER;
            else if (s->length[side] != s->length[other])
                other = PC_NONE;
            *beyond = *beyond == UNSEEN || *beyond == other ? other : PC_NONE;
        }
}

static pc_status find_sides(sides *s, pc_context *ctx) {
    pc_status status = PC_OK;
    const pc_shell *shell = s->shell;
    PC_TRY(pc_new(&s->of_edge, ctx, 2 * (size_t)shell->edge_count));
    PC_TRY(pc_new(&s->length, ctx, 4 * (size_t)shell->face_count));
    PC_TRY(pc_new(&s->beyond, ctx, 4 * (size_t)shell->face_count));
    memset(s->of_edge, 0xff, 2 * (size_t)shell->edge_count * sizeof *s->of_edge);
    for (pc_index f = 0; f < shell->face_count; f++)
        walk_loop(s, f);
    match_sides(s);
done:
    return status;
}

static int name_of(pc_index side) {
    static const int name[4] = {SOUTH, EAST, NORTH, WEST};
    return name[side % 4];
}

/* Patches and sides, then which direction of the second each one of the first becomes, and whether it runs
 * the same way. */
static void put_interface(pc_textout *out, pc_index a, pc_index b) {
    unsigned along = a & 1, other = b & 1, map[2], same[2];
    map[along] = other;
    map[1 - along] = 1 - other;
    same[along] = (a % 4 < 2) != (b % 4 < 2); /* both run counter-clockwise, that is against each other */
    same[1 - along] = (name_of(a) % 2 == 0) != (name_of(b) % 2 == 0); /* out of one is into the other */
    pc_textout_put(out, "%u %d %u %d %u %u %u %u\n", a / 4, name_of(a), b / 4, name_of(b), map[0], map[1],
                   same[0], same[1]);
}

static void put_topology(pc_textout *out, const sides *s) {
    pc_index count = 4 * s->shell->face_count;
    pc_textout_put(out, "<MultiPatch parDim=\"2\" id=\"%u\">\n<patches type=\"id_range\">0 %u</patches>\n",
                   s->shell->face_count, s->shell->face_count - 1);
    pc_textout_put(out, "<interfaces>\n");
    for (pc_index a = 0; a < count; a++) {
        pc_index b = s->beyond[a];
        if (b < count && s->beyond[b] == a && a < b) put_interface(out, a, b);
    }
    pc_textout_put(out, "</interfaces>\n<boundary>\n");
    for (pc_index a = 0; a < count; a++)
        if (s->beyond[a] == BORDER) pc_textout_put(out, "%u %d\n", a / 4, name_of(a));
    pc_textout_put(out, "</boundary>\n</MultiPatch>\n");
}

static void put_knots(pc_textout *out, const double *knot, pc_index count) {
    for (pc_index i = 0; i < count; i++)
        for (int k = 0; k < (i == 0 || i + 1 == count ? 4 : 1); k++) {
            if (i || k) pc_textout_put(out, " ");
            pc_textout_reals(out, knot + i, 1);
        }
}

static void put_patch(pc_textout *out, const pc_shell *shell, pc_index f) {
    const pc_shell_face *face = shell->face + f;
    pc_textout_put(out,
                   "<Geometry type=\"TensorBSpline2\" id=\"%u\">\n<Basis type=\"TensorBSplineBasis2\">\n", f);
    for (int k = 0; k < 2; k++) {
        pc_textout_put(out, "<Basis type=\"BSplineBasis\" index=\"%d\">\n<KnotVector degree=\"3\">", k);
        put_knots(out, shell->knot + face->knot[k], face->point_count[k] - 2);
        pc_textout_put(out, "</KnotVector>\n</Basis>\n");
    }
    pc_textout_put(out, "</Basis>\n<coefs geoDim=\"3\">\n");
    size_t points = (size_t)face->point_count[0] * face->point_count[1];
    for (size_t i = 0; i < points; i++) {
        pc_textout_reals(out, shell->point + 3 * (face->point + i), 3);
        pc_textout_put(out, "\n");
    }
    pc_textout_put(out, "</coefs>\n</Geometry>\n");
}

pc_status pc_gismo_write(pc_context *ctx, const pc_shell *shell, const char *path, bool force) {
    pc_status status = PC_OK;
    sides s = {.shell = shell};
    pc_textout out = {0};
    PC_TRY(find_sides(&s, ctx));
    PC_TRY(pc_textout_open(&out, ctx, path, force));
    pc_textout_put(&out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<xml>\n");
    put_topology(&out, &s);
    for (pc_index f = 0; f < shell->face_count; f++)
        put_patch(&out, shell, f);
    pc_textout_put(&out, "</xml>\n");
done:
    pc_free(ctx, s.of_edge);
    pc_free(ctx, s.length);
    pc_free(ctx, s.beyond);
    return pc_textout_close(&out, status);
}
