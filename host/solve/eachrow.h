/* Parallel loops over rows in which the form of the blocks is a constant. */
#ifndef PC_EACHROW_H
#define PC_EACHROW_H

#define PC_ALWAYS_INLINE static inline __attribute__((always_inline))

/* Loops of fewer rows are not worth waking threads for. */
enum { PC_PARALLEL_ROWS = 2048 };

/* CALL(form, i) for all rows. A loop for each form: a form handed into one loop would be a variable there,
 * because compilers outline parallel loops before they know its value. */
#define PC_ROWS_OF(FORM, CALL)                                                                               \
    _Pragma(                                                                                                 \
        "omp parallel for schedule(static) if (rows_in_all > PC_PARALLEL_ROWS)") for (pc_index row_of_loop = \
                                                                                          0;                 \
                                                                                      row_of_loop <          \
                                                                                      rows_in_all;           \
                                                                                      row_of_loop++)         \
        CALL(FORM, row_of_loop)
#define PC_EACH_ROW(form, rows, CALL)                                                                        \
    do {                                                                                                     \
        const pc_index rows_in_all = (rows);                                                                 \
        if ((form) == PC_FORM_SCALAR) PC_ROWS_OF(PC_FORM_SCALAR, CALL);                                      \
        if ((form) == PC_FORM_COMPLEX) PC_ROWS_OF(PC_FORM_COMPLEX, CALL);                                    \
        if ((form) == PC_FORM_TURNED) PC_ROWS_OF(PC_FORM_TURNED, CALL);                                      \
    } while (0)

#endif
