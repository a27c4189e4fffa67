#include "iges.h"
#include "memory.h"
#include "textout.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    WIDTH = 80,
    GLOBAL_TEXT = 72,    /* columns for text in the sections S and G, */
    PARAMETER_TEXT = 64, /* and in P, where the entity's number follows */
    MOST_LINES = 9999999 /* seven digits */
};

/* A section that is filled parameter by parameter: none is cut, except texts. */
typedef struct iges {
    pc_textout out;
    char section;
    size_t lines; /* of this section so far */
    size_t owner; /* P only: line of the entity in the directory */
    bool dry;     /* the directory stands before the parameters, so their lines are counted first */
    char line[WIDTH + 1];
    size_t used;
} iges;

static void end_line(iges *f) {
    f->lines++;
    if (!f->dry) {
        if (f->section == 'P')
            pc_textout_put(&f->out, "%-64.*s %7zuP%7zu\n", (int)f->used, f->line, f->owner, f->lines);
        else
            pc_textout_put(&f->out, "%-72.*s%c%7zu\n", (int)f->used, f->line, f->section, f->lines);
    }
    f->used = 0;
}

static void add(iges *f, const char *text, size_t length) {
    size_t room = f->section == 'P' ? PARAMETER_TEXT : GLOBAL_TEXT;
    if (f->used + length > room && length <= room) end_line(f);
    while (f->used + length > room) { /* a text longer than a line */
        size_t part = room - f->used;
        memcpy(f->line + f->used, text, part);
        f->used = room;
        text += part, length -= part;
        end_line(f);
    }
    memcpy(f->line + f->used, text, length);
    f->used += length;
}

static void add_integer(iges *f, long long value, char delimiter) {
    char text[32];
    int length = snprintf(text, sizeof text, "%lld%c", value, delimiter);
    add(f, text, (size_t)length);
}

/* Reals have a point; those with more digits than single precision holds an exponent D. */
static void add_real(iges *f, double x, char delimiter) {
    char text[PC_DECIMAL_SPACE], out[PC_DECIMAL_SPACE + 8];
    size_t length = pc_decimal_write(text, x), at = 0, digits = 0;
    bool point = false, exponent = false;
    for (size_t i = 0; i < length; i++) {
        if (text[i] == 'e') {
            if (!point) out[at++] = '.';
            point = exponent = true;
            out[at++] = 'D';
            continue;
        }
        point |= text[i] == '.';
        digits += !exponent && text[i] >= '0' && text[i] <= '9';
        out[at++] = text[i];
    }
    if (!point) out[at++] = '.';
    if (!exponent && digits > 6) out[at++] = 'D', out[at++] = '0';
    out[at++] = delimiter;
    add(f, out, at);
}

static void add_text(iges *f, const char *text, char delimiter) {
    char out[256];
    int length = snprintf(out, sizeof out, "%zuH%.200s%c", strlen(text), text, delimiter);
    add(f, out, (size_t)length);
}

static double largest_coordinate(const pc_shell *shell) {
    double most = 0;
    for (size_t i = 0; i < shell->point_count; i++)
        most = fmax(most, fabs(shell->point[i]));
    return most;
}

static void put_global(iges *f, const pc_shell *shell, double size, const char *name) {
    static const char date[] = "19700101.000000";
    add_text(f, ",", ',');
    add_text(f, ";", ',');
    add_text(f, name, ',');
    add_text(f, name, ',');
    add_text(f, "percale", ',');
    add_text(f, "percale", ',');
    add_integer(f, 32, ',');  /* bits of an integer */
    add_integer(f, 38, ',');  /* powers of ten and digits of single */
    add_integer(f, 6, ',');   /* and */
    add_integer(f, 308, ','); /* double precision */
    add_integer(f, 15, ',');
    add_text(f, name, ',');
    add_real(f, 1, ',');    /* scale */
    add_integer(f, 2, ','); /* millimetres */
    add_text(f, "MM", ',');
    add_integer(f, 1, ','); /* line weights, */
    add_real(f, 0.1, ',');  /* and the widest */
    add_text(f, date, ',');
    add_real(f, size > 0 ? 1e-8 * size : 1e-7, ',');
    add_real(f, largest_coordinate(shell), ',');
    add(f, ",,", 2);         /* author, organization */
    add_integer(f, 11, ','); /* version 5.3 */
    add_integer(f, 0, ',');  /* no drafting standard */
    add_text(f, date, ';');
    end_line(f);
}

/* Fourfold at the ends. */
static void add_knots(iges *f, const double *knot, pc_index count) {
    for (pc_index i = 0; i < count; i++)
        for (int k = 0; k < (i == 0 || i + 1 == count ? 4 : 1); k++)
            add_real(f, knot[i], ',');
}

static void put_face(iges *f, const pc_shell *shell, pc_index number) {
    const pc_shell_face *face = shell->face + number;
    const double *knot[2] = {shell->knot + face->knot[0], shell->knot + face->knot[1]};
    pc_index n = face->point_count[0], m = face->point_count[1];
    f->owner = 2 * (size_t)number + 1;
    add_integer(f, 128, ',');
    add_integer(f, (long long)n - 1, ',');
    add_integer(f, (long long)m - 1, ',');
    add_integer(f, 3, ',');
    add_integer(f, 3, ',');
    add_integer(f, 0, ','); /* not closed along s, */
    add_integer(f, 0, ','); /* along t, */
    add_integer(f, 1, ','); /* polynomial, */
    add_integer(f, 0, ','); /* not periodic along s, */
    add_integer(f, 0, ','); /* along t */
    for (int k = 0; k < 2; k++)
        add_knots(f, knot[k], face->point_count[k] - 2);
    for (size_t i = 0; i < (size_t)n * m; i++)
        add_real(f, 1, ',');
    for (size_t i = 0; i < 3 * (size_t)n * m; i++)
        add_real(f, shell->point[3 * face->point + i], ',');
    for (int k = 0; k < 2; k++) {
        add_real(f, knot[k][0], ',');
        add_real(f, knot[k][face->point_count[k] - 3], k ? ';' : ',');
    }
    end_line(f);
}

static void put_directory(iges *f, const size_t *start, pc_index count) {
    for (pc_index i = 0; i < count; i++) {
        size_t line = 2 * (size_t)i + 1;
        pc_textout_put(&f->out, "%8d%8zu%8d%8d%8d%8d%8d%8d%08dD%7zu\n", 128, start[i] + 1, 0, 0, 0, 0, 0, 0,
                       0, line);
        pc_textout_put(&f->out, "%8d%8d%8d%8zu%8d%8s%8s%8s%8dD%7zu\n", 128, 0, 0, start[i + 1] - start[i], 0,
                       "", "", "FACE", 0, line + 1);
    }
}

static void begin_section(iges *f, char section, bool dry) {
    f->section = section;
    f->lines = 0;
    f->dry = dry;
}

static void clean_name(char clean[128], const char *name) {
    size_t at = 0;
    for (; *name && at < 127; name++)
        clean[at++] = *name >= ' ' && *name <= '~' ? *name : '_';
    clean[at] = 0;
}

static pc_status put_all(iges *f, pc_context *ctx, const pc_shell *shell, double size, const char *name) {
    pc_status status = PC_OK;
    static const char about[] = "B-spline surfaces of a T-spline, by percale";
    size_t *start = NULL; /* per face: parameter lines before its own */
    PC_TRY(pc_new(&start, ctx, (size_t)shell->face_count + 1));
    begin_section(f, 'P', true);
    for (pc_index i = 0; i < shell->face_count; i++) {
        put_face(f, shell, i);
        start[i + 1] = f->lines;
    }
    if (f->lines > MOST_LINES || 2 * (size_t)shell->face_count > MOST_LINES)
        PC_TRY(pc_fail(ctx, PC_E_IO, "%zu lines are too many for IGES", f->lines));
    begin_section(f, 'S', false);
    add(f, about, strlen(about));
    end_line(f);
    begin_section(f, 'G', false);
    put_global(f, shell, size, name);
    size_t global = f->lines;
    put_directory(f, start, shell->face_count);
    begin_section(f, 'P', false);
    for (pc_index i = 0; i < shell->face_count; i++)
        put_face(f, shell, i);
    pc_textout_put(&f->out, "S%7dG%7zuD%7zuP%7zu%40sT%7d\n", 1, global, 2 * (size_t)shell->face_count,
                   f->lines, "", 1);
done:
    pc_free(ctx, start);
    return status;
}

pc_status pc_iges_write(pc_context *ctx, const pc_shell *shell, double size, const char *name,
                        const char *path, bool force) {
    pc_status status = PC_OK;
    iges file = {.dry = true};
    char clean[128];
    clean_name(clean, name);
    PC_TRY(pc_textout_open(&file.out, ctx, path, force));
    PC_TRY(put_all(&file, ctx, shell, size, clean));
done:
    return pc_textout_close(&file.out, status);
}
