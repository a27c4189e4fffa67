/* Evaluates the T-spline of a finished run: at places, on a grid, or nearest to points. */
#include "command.h"
#include "decimal.h"
#include "differential.h"
#include "file.h"
#include "folder.h"
#include "memory.h"
#include "nearest.h"
#include "spline_store.h"
#include "triples.h"
#include <string.h>
#include <sys/stat.h>

static const char usage[] = "eval OUT|FILE.h5 --at FILE | --grid N | --project FILE [OPTIONS]";
static const char about[] =
    "Evaluates the T-spline that `percale convert --tolerance` left in the folder OUT, or in a result or\n"
    "stage file, and writes a table in CSV: face, s, t (0 to 1 across the face), the point, the unit "
    "normal.\n"
    "FILE has three numbers per line, parted by blanks or commas; - is standard input.";

/* Where the table goes: a file, written aside and put in place at the end, or standard output. */
typedef struct sheet {
    pc_context *ctx;
    const char *path; /* NULL: standard output */
    pc_writer writer;
    size_t rows;
    bool derivatives, distances;
} sheet;

/* One line of it; a number takes up to PC_DECIMAL_SPACE characters and a comma. */
typedef struct row {
    char text[32 * (PC_DECIMAL_SPACE + 1)];
    size_t used;
} row;

static pc_status put_text(sheet *to, const char *text, size_t length) {
    if (to->path) return pc_writer_put(&to->writer, text, length);
    if (fwrite(text, 1, length, stdout) == length) return PC_OK;
    return pc_fail(to->ctx, PC_E_IO, "standard output cannot be written");
}

static pc_status open_sheet(sheet *to, const char *path, bool force) {
    struct stat there;
    if (!path || strcmp(path, "-") == 0) return PC_OK;
    if (!force && stat(path, &there) == 0)
        return pc_fail(to->ctx, PC_E_USAGE, "%s: exists; --force overwrites it", path);
    to->path = path;
    return pc_writer_open(&to->writer, to->ctx, path, force);
}

/* Once the input is read, so that no table begins that cannot go on. */
static pc_status put_head(sheet *to) {
    char head[256];
    int length =
        snprintf(head, sizeof head, "face,s,t,x,y,z,nx,ny,nz%s%s\n", to->distances ? ",distance" : "",
                 to->derivatives ? ",xs,ys,zs,xt,yt,zt,xss,yss,zss,xst,yst,zst,xtt,ytt,ztt,k1,k2" : "");
    return put_text(to, head, (size_t)length);
}

static void put_number(row *r, double value) {
    if (r->used) r->text[r->used++] = ',';
    if (isfinite(value)) r->used += pc_decimal_write(r->text + r->used, value);
}

static void put_vector(row *r, double scale, pc_vec3 v) {
    put_number(r, scale * v.x), put_number(r, scale * v.y), put_number(r, scale * v.z);
}

/* `part` is the place in 0..1 of the face; derivatives are per unit of these. */
static pc_status put_row(sheet *to, const pc_tspline *spline, pc_surface_place place, const double part[2],
                         double distance) {
    pc_index face = spline->basis.element[place.element].face;
    const double *size = spline->mesh.face[face].size;
    pc_surface_point at = pc_tspline_evaluate(spline, place);
    double k[2];
    row r = {.used = 0};
    put_number(&r, face), put_number(&r, part[0]), put_number(&r, part[1]);
    put_vector(&r, 1, at.p);
    put_vector(&r, 1, pc_surface_normal(&at));
    if (to->distances) put_number(&r, distance);
    if (to->derivatives) {
        put_vector(&r, size[0], at.s), put_vector(&r, size[1], at.t);
        put_vector(&r, size[0] * size[0], at.ss), put_vector(&r, size[0] * size[1], at.st);
        put_vector(&r, size[1] * size[1], at.tt);
        bool curved = pc_surface_curvatures(k, &at);
        put_number(&r, curved ? k[0] : NAN), put_number(&r, curved ? k[1] : NAN);
    }
    r.text[r.used++] = '\n';
    pc_status status = put_text(to, r.text, r.used);
    return status == PC_OK && ++to->rows % 4096 == 0 ? pc_check_interrupt(to->ctx) : status;
}

static pc_status put_part(sheet *to, const pc_tspline *spline, pc_index face, const double part[2]) {
    const double *size = spline->mesh.face[face].size;
    return put_row(to, spline, pc_tspline_place(spline, face, part[0] * size[0], part[1] * size[1]), part, 0);
}

static pc_status check_place(pc_context *ctx, const pc_tspline *spline, const char *path, size_t line,
                             const double value[3]) {
    const char *name = strcmp(path, "-") == 0 ? "standard input" : path;
    pc_index faces = spline->mesh.face_count;
    if (!(value[0] >= 0 && value[0] < faces && value[0] == floor(value[0])))
        return pc_fail(ctx, PC_E_FORMAT, "%s:%zu: there is no face %.10g; the last is %u", name, line,
                       value[0], faces - 1);
    if (spline->mesh.face[(pc_index)value[0]].ghost)
        return pc_fail(ctx, PC_E_FORMAT, "%s:%zu: face %.10g is beyond the border of the surface", name, line,
                       value[0]);
    for (int k = 1; k < 3; k++)
        if (!(value[k] >= 0 && value[k] <= 1))
            return pc_fail(ctx, PC_E_FORMAT, "%s:%zu: %c is %.10g, not in 0 to 1", name, line, "fst"[k],
                           value[k]);
    return PC_OK;
}

static pc_status put_places(sheet *to, const pc_tspline *spline, const char *path) {
    pc_status status = PC_OK;
    pc_triples places;
    PC_TRY(pc_triples_read(&places, to->ctx, path, "face s t"));
    for (size_t i = 0; i < places.count; i++)
        PC_TRY(check_place(to->ctx, spline, path, places.line[i], places.value + 3 * i));
    PC_TRY(put_head(to));
    for (size_t i = 0; i < places.count; i++)
        PC_TRY(put_part(to, spline, (pc_index)places.value[3 * i], places.value + 3 * i + 1));
done:
    pc_triples_free(&places, to->ctx);
    return status;
}

static pc_status put_grid(sheet *to, const pc_tspline *spline, uint64_t n) {
    pc_status status = put_head(to);
    if (status != PC_OK) return status;
    for (pc_index f = 0; f < spline->mesh.face_count; f++)
        for (uint64_t i = 0; i < n * n && !spline->mesh.face[f].ghost; i++) {
            const uint64_t column = i % n, line = i / n;
            double last = (double)(n - 1);
            PC_TRY(put_part(to, spline, f, (const double[2]){(double)column / last, (double)line / last}));
        }
done:
    return status;
}

static pc_status put_nearest(sheet *to, const pc_tspline *spline, const char *path) {
    enum { FACETS = 4 }; /* squares per side of an element to start from */
    pc_status status = PC_OK;
    pc_triples points;
    pc_facets facets = {0};
    pc_nearest *nearest = NULL;
    PC_TRY(pc_triples_read(&points, to->ctx, path, "x y z"));
    PC_TRY(pc_facets_make(&facets, to->ctx, spline, FACETS, false));
    PC_TRY(pc_new(&nearest, to->ctx, points.count));
    pc_nearest_all(nearest, spline, &facets, points.value, points.count);
    PC_TRY(put_head(to));
    for (size_t i = 0; i < points.count; i++) {
        pc_surface_place place = nearest[i].place;
        const double *size = spline->mesh.face[spline->basis.element[place.element].face].size;
        double part[2] = {fmin(fmax(place.s / size[0], 0), 1), fmin(fmax(place.t / size[1], 0), 1)};
        PC_TRY(put_row(to, spline, place, part, nearest[i].distance));
    }
done:
    pc_free(to->ctx, nearest);
    pc_facets_free(&facets, to->ctx);
    pc_triples_free(&points, to->ctx);
    return status;
}

/* `from` is the folder of a run, or a file. */
static pc_status load(pc_tspline *spline, pc_context *ctx, const char *from) {
    pc_status status = PC_OK;
    pc_store *store = NULL;
    char *path = NULL;
    struct stat about_it;
    bool folder = stat(from, &about_it) == 0 && S_ISDIR(about_it.st_mode);
    if (folder) PC_TRY(pc_folder_join(&path, ctx, from, PC_OUT_RESULT, ""));
    PC_TRY(pc_store_open(&store, ctx, folder ? path : from));
    if (!pc_store_has(store, "spline"))
        PC_TRY(pc_fail(ctx, PC_E_USAGE, "%s: holds no spline; percale convert --tolerance makes one", from));
    PC_TRY(pc_tspline_load(spline, store, "spline"));
done:
    pc_store_close(store);
    pc_free(ctx, path);
    return status;
}

/* What the command line asks for. */
typedef struct eval_line {
    const char *from, *at, *project, *out;
    uint64_t grid;
    bool derivatives, force;
} eval_line;

static pc_status evaluate(pc_context *ctx, const eval_line *line) {
    pc_status status = PC_OK;
    pc_tspline spline = {0};
    sheet to = {.ctx = ctx, .derivatives = line->derivatives, .distances = line->project};
    PC_TRY(load(&spline, ctx, line->from));
    PC_TRY(open_sheet(&to, line->out, line->force));
    if (line->at) PC_TRY(put_places(&to, &spline, line->at));
    if (line->grid) PC_TRY(put_grid(&to, &spline, line->grid));
    if (line->project) PC_TRY(put_nearest(&to, &spline, line->project));
    if (to.path) PC_TRY(pc_writer_commit(&to.writer));
done:
    pc_writer_abandon(&to.writer);
    pc_tspline_free(&spline, ctx);
    return status;
}

pc_status pc_command_eval(pc_context *ctx, int argc, const char **argv) {
    eval_line line = {0};
    pc_option table[] = {
        PC_TEXT("at", 0, &line.at, "FILE", "at places: lines of 'face s t'"),
        PC_COUNT("grid", &line.grid, "N", 2, 1000, "at N x N points of every face, borders included"),
        PC_TEXT("project", 0, &line.project, "FILE",
                "at the points of the surface nearest to others, lines of 'x y z'; the table has their "
                "distance too"),
        PC_FLAG("derivatives", 0, &line.derivatives,
                "first and second derivatives by s and t, and the principal curvatures k1 >= k2, positive "
                "where convex"),
        PC_TEXT("output", 'o', &line.out, "FILE", "the table (default: standard output)"),
        PC_FLAG("force", 0, &line.force, "overwrite the table"),
        PC_OPTIONS_END,
    };
    pc_operands operands;
    pc_status status = PC_OK;
    PC_TRY(pc_options_read(&operands, ctx, table, argc, argv));
    if (operands.help_asked) {
        pc_command_help(usage, about, table);
        goto done;
    }
    PC_TRY(pc_command_operands(ctx, &operands, 1, usage));
    line.from = operands.text[0];
    if ((line.at != NULL) + (line.grid != 0) + (line.project != NULL) != 1)
        PC_TRY(pc_fail(ctx, PC_E_USAGE, "eval wants one of --at FILE, --grid N and --project FILE"));
    PC_TRY(evaluate(ctx, &line));
done:
    return status;
}
