#ifndef PC_CONTEXT_PRIVATE_H
#define PC_CONTEXT_PRIVATE_H

#include "context.h"
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>

/* Large blocks that were freed, for the next ones. */
typedef struct pc_spare_blocks {
    pthread_mutex_t lock;
    struct {
        void *base;
        size_t mapped;
    } block[32];
    size_t count;
    size_t bytes;
} pc_spare_blocks;

struct pc_context {
    atomic_size_t used;
    atomic_size_t peak;
    atomic_size_t most; /* ever used */
    pc_spare_blocks spare;
    atomic_size_t fail_at;
    volatile sig_atomic_t interrupted;
    pthread_mutex_t message_lock;
    char message[2048];
    pc_log_sink *log_sink;
    void *log_user;
    pc_log_level log_least;
    pc_progress_sink *progress_sink;
    void *progress_user;
};

#endif
