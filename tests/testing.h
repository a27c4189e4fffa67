/* What all tests share: a context per test that must end with no memory alive, and clear failures. */
#ifndef PC_TESTING_H
#define PC_TESTING_H

#include "context.h"
#include "memory.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static inline int make_context(void **state) {
    *state = pc_context_make();
    return *state ? 0 : -1;
}

static inline int free_context(void **state) {
    size_t left = pc_memory_used(*state);
    if (left) {
        (void)fprintf(stderr, "%zu bytes are still allocated\n", left);
        return -1;
    }
    pc_context_free(*state);
    return 0;
}

#define assert_ok(ctx, call)                                                                                 \
    do {                                                                                                     \
        pc_status status_of_call = (call);                                                                   \
        if (status_of_call != PC_OK)                                                                         \
            fail_msg("%s: %s (%s)", #call, pc_status_name(status_of_call), pc_context_message(ctx));         \
    } while (0)

#endif
