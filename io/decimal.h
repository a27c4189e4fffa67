/* Decimal numbers in text, the same in every locale: correctly rounded when read, shortest when written. */
#ifndef PC_DECIMAL_H
#define PC_DECIMAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum pc_decimal_result {
    PC_DECIMAL_OK,
    PC_DECIMAL_NONE,      /* no number stands here; the cursor did not move */
    PC_DECIMAL_NOT_FINITE /* nan, inf, or a number beyond the largest double */
} pc_decimal_result;

/* Reads [+-]digits[.digits][e[+-]digits] at *at, before `end`, and moves *at behind it; what follows is the
 * caller's matter. Rounds to nearest even. */
pc_decimal_result pc_decimal_read(double *value, const char **at, const char *end);

/* Reads [+-]digits; false (and *at stays) where there are none. A value beyond +-2^62 is given as +-2^62. */
bool pc_decimal_read_integer(int64_t *value, const char **at, const char *end);

enum { PC_DECIMAL_SPACE = 32 };
/* Writes the shortest decimal that reads back as `value` (finite), 0-terminated; returns its length. */
size_t pc_decimal_write(char text[PC_DECIMAL_SPACE], double value);

#endif
