/* The lesser and the greater of two numbers as bare comparisons: fmin and fmax are calls, for the sake of
 * NaN. */
#ifndef PC_PICK_H
#define PC_PICK_H

static inline float pc_lesser(float a, float b) {
    return a < b ? a : b;
}
static inline float pc_greater(float a, float b) {
    return a > b ? a : b;
}

#endif
