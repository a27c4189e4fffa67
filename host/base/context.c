#include "context_private.h"
#include "memory.h"
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

pc_context *pc_context_make(void) {
    pc_context *ctx = calloc(1, sizeof *ctx);
    if (!ctx) return NULL;
    ctx->log_least = PC_LOG_WARNING;
    if (pthread_mutex_init(&ctx->message_lock, NULL) != 0) goto failed;
    if (pthread_mutex_init(&ctx->spare.lock, NULL) != 0) {
        pthread_mutex_destroy(&ctx->message_lock);
        goto failed;
    }
    return ctx;
failed:
    free(ctx);
    return NULL;
}

void pc_context_free(pc_context *ctx) {
    if (!ctx) return;
    assert(ctx->used == 0);
    pc_memory_release(ctx);
    pthread_mutex_destroy(&ctx->spare.lock);
    pthread_mutex_destroy(&ctx->message_lock);
    free(ctx);
}

pc_status pc_fail(pc_context *ctx, pc_status status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    pthread_mutex_lock(&ctx->message_lock);
    if (ctx->message[0] == '\0') (void)vsnprintf(ctx->message, sizeof ctx->message, format, arguments);
    pthread_mutex_unlock(&ctx->message_lock);
    va_end(arguments);
    return status;
}

const char *pc_context_message(const pc_context *ctx) {
    return ctx->message;
}

void pc_context_clear_message(pc_context *ctx) {
    ctx->message[0] = '\0';
}

void pc_context_set_log(pc_context *ctx, pc_log_sink *sink, void *user, pc_log_level least) {
    ctx->log_sink = sink;
    ctx->log_user = user;
    ctx->log_least = least;
}

void pc_log(pc_context *ctx, pc_log_level level, const char *format, ...) {
    if (!ctx->log_sink || level > ctx->log_least) return;
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    ctx->log_sink(ctx->log_user, level, line);
}

void pc_context_set_progress(pc_context *ctx, pc_progress_sink *sink, void *user) {
    ctx->progress_sink = sink;
    ctx->progress_user = user;
}

void pc_progress(pc_context *ctx, double fraction) {
    if (ctx->progress_sink) ctx->progress_sink(ctx->progress_user, fraction);
}

void pc_context_interrupt(pc_context *ctx) {
    ctx->interrupted = 1;
}

pc_status pc_check_interrupt(pc_context *ctx) {
    if (!ctx->interrupted) return PC_OK;
    return pc_fail(ctx, PC_E_INTERRUPT, "interrupted");
}
