#include "options.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_WORD = 32, MOST_OPTIONS = 64 };

/* Edits (insert, delete, replace, swap of neighbours) between two short words. */
static int edit_distance(const char *a, const char *b) {
    int table[LONGEST_WORD + 1][LONGEST_WORD + 1];
    int m = (int)strlen(a), n = (int)strlen(b);
    if (m > LONGEST_WORD || n > LONGEST_WORD) return LONGEST_WORD;
    for (int i = 0; i <= m; i++)
        for (int j = 0; j <= n; j++) {
            if (i == 0 || j == 0) {
                table[i][j] = i + j;
                continue;
            }
            int best = table[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            if (table[i - 1][j] + 1 < best) best = table[i - 1][j] + 1;
            if (table[i][j - 1] + 1 < best) best = table[i][j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
                table[i - 2][j - 2] + 1 < best)
                best = table[i - 2][j - 2] + 1;
            table[i][j] = best;
        }
    return table[m][n];
}

const char *pc_nearest_word(const char *typed, const char *const *words) {
    const char *nearest = NULL;
    int best = (int)strlen(typed) / 3 + 2;
    for (; *words; words++) {
        int distance = edit_distance(typed, *words);
        size_t length = strlen(typed);
        if (length >= 3 && strncmp(typed, *words, length) == 0) distance = 1;
        if (distance < best) {
            best = distance;
            nearest = *words;
        }
    }
    return nearest;
}

static pc_status fail_unknown(pc_context *ctx, const pc_option *table, const char *typed,
                              const char *command) {
    const char *words[MOST_OPTIONS + 1];
    char name[64] = "";
    int count = 0;
    size_t length = strcspn(typed, "=");
    (void)snprintf(name, sizeof name, "%.*s", (int)length, typed);
    for (; table[count].name && count < MOST_OPTIONS; count++)
        words[count] = table[count].name;
    words[count] = NULL;
    const char *dashless = name + strspn(name, "-");
    const char *nearest = pc_nearest_word(dashless, words);
    if (nearest) return pc_fail(ctx, PC_E_USAGE, "unknown option %s; did you mean --%s?", name, nearest);
    return pc_fail(ctx, PC_E_USAGE, "unknown option %s; 'percale help %s' lists them all", name, command);
}

static pc_status fail_value(pc_context *ctx, const pc_option *option, const char *text, const char *wanted) {
    return pc_fail(ctx, PC_E_USAGE, "--%s wants %s, not '%s'", option->name, wanted, text);
}

static pc_status check_limits(pc_context *ctx, const pc_option *option, const char *text, double value) {
    if (option->least == option->most || (value >= option->least && value <= option->most)) return PC_OK;
    char wanted[80];
    if (isinf(option->most))
        (void)snprintf(wanted, sizeof wanted, "at least %.10g", option->least);
    else
        (void)snprintf(wanted, sizeof wanted, "a value from %.10g to %.10g", option->least, option->most);
    return fail_value(ctx, option, text, wanted);
}

static pc_status read_number(pc_context *ctx, const pc_option *option, const char *text) {
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end || !isfinite(value)) return fail_value(ctx, option, text, "a number");
    *(double *)option->value = value;
    return check_limits(ctx, option, text, value);
}

static pc_status read_count(pc_context *ctx, const pc_option *option, const char *text) {
    char *end;
    double value = strtod(text, &end);
    if (end != text && (*end == 'k' || *end == 'K')) {
        value *= 1e3;
        end++;
    } else if (end != text && (*end == 'm' || *end == 'M')) {
        value *= 1e6;
        end++;
    }
    /* 2^53 and up would not be exact */
    if (end == text || *end || !(value >= 0 && value < 0x1p53) || fabs(value - round(value)) > 1e-6 * value)
        return fail_value(ctx, option, text, "a whole number such as 20000, 20k or 1.5M");
    *(uint64_t *)option->value = (uint64_t)llround(value);
    return check_limits(ctx, option, text, value);
}

static pc_status read_choice(pc_context *ctx, const pc_option *option, const char *text) {
    const char *word = option->choices;
    for (int place = 0; *word; place++) {
        size_t length = strcspn(word, "|");
        if (strlen(text) == length && strncmp(text, word, length) == 0) {
            *(int *)option->value = place;
            return PC_OK;
        }
        word += length + (word[length] == '|');
    }
    return pc_fail(ctx, PC_E_USAGE, "--%s wants one of %s, not '%s'", option->name, option->choices, text);
}

static pc_status read_size(pc_context *ctx, const pc_option *option, const char *text) {
    unsigned long side[2];
    char *end;
    errno = 0;
    side[0] = strtoul(text, &end, 10);
    bool good = end != text && (*end == 'x' || *end == 'X');
    const char *second = good ? end + 1 : text;
    side[1] = strtoul(second, &end, 10);
    good = good && end != second && *end == '\0' && errno == 0;
    for (int k = 0; k < 2; k++)
        good = good && side[k] >= 16 && side[k] <= 16384;
    if (!good) return fail_value(ctx, option, text, "WIDTHxHEIGHT from 16 to 16384, such as 1600x1200");
    for (int k = 0; k < 2; k++)
        ((uint32_t *)option->value)[k] = (uint32_t)side[k];
    return PC_OK;
}

static pc_status read_value(pc_context *ctx, pc_option *option, const char *text) {
    option->given = true;
    switch (option->kind) {
    case PC_OPTION_FLAG:
        *(bool *)option->value = true;
        return PC_OK;
    case PC_OPTION_TEXT:
        if (!*text) return fail_value(ctx, option, text, "a text");
        *(const char **)option->value = text;
        return PC_OK;
    case PC_OPTION_COUNT:
        return read_count(ctx, option, text);
    case PC_OPTION_NUMBER:
        return read_number(ctx, option, text);
    case PC_OPTION_CHOICE:
        return read_choice(ctx, option, text);
    case PC_OPTION_SIZE:
        return read_size(ctx, option, text);
    }
    return PC_E_BUG;
}

/* The option that `argument` names, and what follows its '=' or its letter; NULL where unknown. */
static pc_option *find_option(pc_option *table, const char *argument, const char **attached) {
    *attached = NULL;
    for (pc_option *option = table; option->name; option++) {
        size_t length = strlen(option->name);
        if (argument[1] == '-' && strncmp(argument + 2, option->name, length) == 0 &&
            (argument[2 + length] == '\0' || argument[2 + length] == '=')) {
            if (argument[2 + length] == '=') *attached = argument + 3 + length;
            return option;
        }
        if (argument[1] != '-' && option->letter && argument[1] == option->letter) {
            if (argument[2]) *attached = argument + 2;
            return option;
        }
    }
    return NULL;
}

pc_status pc_options_read(pc_operands *operands, pc_context *ctx, pc_option *table, int argc,
                          const char **argv) {
    bool only_operands = false;
    *operands = (pc_operands){.text = argv};
    const char *command = argv[0];
    for (int i = 1; i < argc; i++) {
        const char *argument = argv[i];
        if (only_operands || argument[0] != '-' || argument[1] == '\0') {
            argv[operands->count++] = argument;
            continue;
        }
        if (strcmp(argument, "--") == 0) {
            only_operands = true;
            continue;
        }
        if (strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0) {
            operands->help_asked = true;
            return PC_OK;
        }
        const char *text;
        pc_option *option = find_option(table, argument, &text);
        if (!option) return fail_unknown(ctx, table, argument, command);
        if (option->kind == PC_OPTION_FLAG && text)
            return pc_fail(ctx, PC_E_USAGE, "--%s takes no value", option->name);
        if (option->kind != PC_OPTION_FLAG && !text) {
            if (i + 1 == argc)
                return pc_fail(ctx, PC_E_USAGE, "--%s wants a value: --%s %s", option->name, option->name,
                               option->argument);
            text = argv[++i];
        }
        pc_status status = read_value(ctx, option, text);
        if (status != PC_OK) return status;
    }
    return PC_OK;
}

/* Breaks `text` at spaces so that it fits between columns 30 and 80. */
static void print_wrapped(FILE *out, const char *text) {
    enum { INDENT = 30, WIDTH = 50 };
    while (*text) {
        size_t length = strlen(text);
        if (length > WIDTH) {
            length = WIDTH;
            while (length > 0 && text[length] != ' ')
                length--;
            if (length == 0) length = strcspn(text, " ");
        }
        (void)fprintf(out, "%.*s\n", (int)length, text);
        text += length + (text[length] == ' ');
        if (*text) (void)fprintf(out, "%*s", INDENT, "");
    }
}

void pc_options_print(FILE *out, const pc_option *table) {
    for (const pc_option *option = table; option->name; option++) {
        char left[96], letter[5] = "    ";
        if (option->letter) (void)snprintf(letter, sizeof letter, "-%c, ", option->letter);
        (void)snprintf(left, sizeof left, "  %s--%s%s%s", letter, option->name, option->argument ? " " : "",
                       option->argument ? option->argument : "");
        if (strlen(left) > 29)
            (void)fprintf(out, "%s\n%30s", left, "");
        else
            (void)fprintf(out, "%-30s", left);
        print_wrapped(out, option->help);
    }
    (void)fprintf(out, "  -h, --help                  print this help\n");
}
