/* What every call shares: counted memory, the first error message, the log, the wish to stop. */
#ifndef PC_CONTEXT_H
#define PC_CONTEXT_H

#include "status.h"
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef uint32_t pc_index; /* vertex, face, edge, or half-edge = 3*face+k */
#define PC_NONE UINT32_MAX

typedef struct pc_context pc_context;

typedef enum pc_log_level { PC_LOG_ERROR, PC_LOG_WARNING, PC_LOG_INFO, PC_LOG_DEBUG } pc_log_level;
typedef void pc_log_sink(void *user, pc_log_level level, const char *line);
/* Progress of the running stage, fraction in 0..1. */
typedef void pc_progress_sink(void *user, double fraction);

/* NULL where memory cannot be had. */
pc_context *pc_context_make(void);
/* Frees the context; everything allocated through it must have been freed. NULL is fine. */
void pc_context_free(pc_context *ctx);

/* Keeps the first message (the cause) and returns `status`, so that `return pc_fail(...)` reads well. */
pc_status pc_fail(pc_context *ctx, pc_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The kept message, "" where there is none. */
const char *pc_context_message(const pc_context *ctx);
void pc_context_clear_message(pc_context *ctx);

void pc_context_set_log(pc_context *ctx, pc_log_sink *sink, void *user, pc_log_level least);
void pc_log(pc_context *ctx, pc_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void pc_context_set_progress(pc_context *ctx, pc_progress_sink *sink, void *user);
void pc_progress(pc_context *ctx, double fraction);

/* Safe in a signal handler. Long loops call pc_check_interrupt now and then and hand its status on. */
void pc_context_interrupt(pc_context *ctx);
pc_status pc_check_interrupt(pc_context *ctx);

#endif
