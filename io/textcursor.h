/* A place in a text that is being read: words between blanks, across or within lines. */
#ifndef PC_TEXTCURSOR_H
#define PC_TEXTCURSOR_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

typedef struct pc_textcursor {
    const char *at;
    const char *end;
} pc_textcursor;

static inline bool pc_is_newline(char c) {
    return c == '\n' || c == '\r';
}
static inline bool pc_is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}
static inline bool pc_is_space(char c) {
    return pc_is_blank(c) || pc_is_newline(c);
}

static inline void pc_skip_blanks(pc_textcursor *c) {
    while (c->at < c->end && pc_is_blank(*c->at))
        c->at++;
}

static inline void pc_skip_spaces(pc_textcursor *c) {
    while (c->at < c->end && pc_is_space(*c->at))
        c->at++;
}

/* To the newline that ends the line, or the end. */
static inline void pc_skip_line(pc_textcursor *c) {
    while (c->at < c->end && !pc_is_newline(*c->at))
        c->at++;
}

/* To the next word that no '#' comments out, across lines; false at the end. */
static inline bool pc_skip_comments(pc_textcursor *c) {
    for (;;) {
        pc_skip_spaces(c);
        if (c->at == c->end) return false;
        if (*c->at != '#') return true;
        pc_skip_line(c);
    }
}

/* After the blanks of a line: its end, a comment, or the end of all. */
static inline bool pc_at_line_end(pc_textcursor *c) {
    pc_skip_blanks(c);
    return c->at == c->end || pc_is_newline(*c->at) || *c->at == '#';
}

/* At the end of a word. */
static inline bool pc_at_word_end(const pc_textcursor *c) {
    return c->at == c->end || pc_is_space(*c->at);
}

/* The word at c->at; its end. */
static inline const char *pc_word_end(const pc_textcursor *c) {
    const char *p = c->at;
    while (p < c->end && !pc_is_space(*p))
        p++;
    return p;
}

static inline bool pc_word_is(const char *at, const char *end, const char *word) {
    size_t n = strlen(word);
    return (size_t)(end - at) == n && memcmp(at, word, n) == 0;
}

#endif
