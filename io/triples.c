#include "triples.h"
#include "decimal.h"
#include "file.h"
#include "memory.h"
#include "scan_input.h"
#include "textcursor.h"
#include <ctype.h>

typedef struct reading {
    pc_triples *to;
    size_t room, line;
    const char *name, *what;
    pc_textcursor at;
} reading;

static pc_status grow(reading *r, pc_context *ctx) {
    pc_status status = PC_OK;
    if (r->to->count < r->room) return PC_OK;
    size_t room = 2 * r->room + 1024;
    PC_TRY(pc_resize(&r->to->value, ctx, 3 * room));
    PC_TRY(pc_resize(&r->to->line, ctx, room));
    r->room = room;
done:
    return status;
}

/* A comma between two numbers, with blanks or not. */
static void skip_comma(pc_textcursor *c) {
    pc_skip_blanks(c);
    if (c->at < c->end && *c->at == ',') c->at++;
    pc_skip_blanks(c);
}

static pc_status expected(const reading *r, pc_context *ctx, const char *at) {
    if (at == r->at.end || pc_is_newline(*at) || *at == '#')
        return pc_fail(ctx, PC_E_FORMAT, "%s:%zu: the line ends before '%s' is complete", r->name, r->line,
                       r->what);
    pc_textcursor word = {at, r->at.end};
    return pc_fail(ctx, PC_E_FORMAT, "%s:%zu: expected '%s', found '%s'", r->name, r->line, r->what,
                   pc_scan_quote(at, pc_word_end(&word)).text);
}

static pc_status read_row(reading *r, pc_context *ctx) {
    pc_status status = PC_OK;
    PC_TRY(grow(r, ctx));
    double *value = r->to->value + 3 * r->to->count;
    for (int k = 0; k < 3; k++) {
        if (k > 0) skip_comma(&r->at);
        const char *at = r->at.at;
        bool read = pc_decimal_read(value + k, &r->at.at, r->at.end) == PC_DECIMAL_OK;
        if (!read || !(pc_at_word_end(&r->at) || *r->at.at == ',' || *r->at.at == '#'))
            return expected(r, ctx, at);
    }
    if (!pc_at_line_end(&r->at)) return expected(r, ctx, r->at.at);
    r->to->line[r->to->count++] = r->line;
done:
    return status;
}

/* Lines end with \n, \r\n or \r. */
static void next_line(reading *r) {
    pc_skip_line(&r->at);
    if (r->at.at < r->at.end && *r->at.at++ == '\r' && r->at.at < r->at.end && *r->at.at == '\n') r->at.at++;
    r->line++;
}

pc_status pc_triples_read(pc_triples *triples, pc_context *ctx, const char *path, const char *what) {
    pc_status status = PC_OK;
    pc_file file = {0};
    bool standard = strcmp(path, "-") == 0;
    reading r = {.to = triples, .line = 1, .name = standard ? "standard input" : path, .what = what};
    *triples = (pc_triples){0};
    PC_TRY(pc_file_open(&file, ctx, standard ? "/dev/stdin" : path));
    r.at = (pc_textcursor){file.data, file.data + file.size};
    for (; r.at.at < r.at.end; next_line(&r)) {
        if (pc_at_line_end(&r.at)) continue;
        if (r.line == 1 && isalpha((unsigned char)*r.at.at)) continue;
        PC_TRY(read_row(&r, ctx));
        if (triples->count % 65536 == 0) PC_TRY(pc_check_interrupt(ctx));
    }
done:
    pc_file_close(&file, ctx);
    if (status != PC_OK) pc_triples_free(triples, ctx);
    return status;
}

void pc_triples_free(pc_triples *triples, pc_context *ctx) {
    pc_free(ctx, triples->value);
    pc_free(ctx, triples->line);
    *triples = (pc_triples){0};
}
