#define _DEFAULT_SOURCE /* madvise */
#include "file.h"
#include "memory.h"
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static pc_status fail_errno(pc_context *ctx, const char *path, const char *what) {
    char reason[128] = "unknown error";
    int code = errno;
    (void)strerror_r(code, reason, sizeof reason);
    return pc_fail(ctx, PC_E_IO, "%s: %s: %s", path, what, reason);
}

/* ---- reading ---- */

static pc_status map_file(pc_file *file, pc_context *ctx, const char *path, int descriptor, size_t size) {
    file->data = "";
    if (size == 0) return PC_OK;
    void *map = mmap(NULL, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (map == MAP_FAILED) return fail_errno(ctx, path, "cannot be mapped");
    (void)madvise(map, size, MADV_WILLNEED);
    file->map = map;
    file->data = map;
    file->size = size;
    return PC_OK;
}

static pc_status read_stream(pc_file *file, pc_context *ctx, const char *path, int descriptor) {
    pc_status status = PC_OK;
    size_t room = 0;
    for (;;) {
        if (file->size == room) {
            room = 2 * room + ((size_t)1 << 20);
            PC_TRY(pc_resize_bytes(&file->buffer, ctx, room, 1));
        }
        ssize_t got = read(descriptor, (char *)file->buffer + file->size, room - file->size);
        if (got == 0) break;
        if (got > 0) file->size += (size_t)got;
        if (got < 0 && errno != EINTR) return fail_errno(ctx, path, "cannot be read");
        PC_TRY(pc_check_interrupt(ctx));
    }
    file->data = file->buffer;
done:
    return status;
}

pc_status pc_file_open(pc_file *file, pc_context *ctx, const char *path) {
    pc_status status = PC_OK;
    struct stat about;
    *file = (pc_file){0};
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0 || fstat(descriptor, &about) != 0)
        status = fail_errno(ctx, path, "cannot be opened");
    else if (S_ISDIR(about.st_mode))
        status = pc_fail(ctx, PC_E_IO, "%s: is a folder, not a file", path);
    else if (S_ISREG(about.st_mode) && about.st_size > 0)
        status = map_file(file, ctx, path, descriptor, (size_t)about.st_size);
    else
        status = read_stream(file, ctx, path, descriptor);
    if (descriptor >= 0) (void)close(descriptor);
    if (status != PC_OK) pc_file_close(file, ctx);
    return status;
}

void pc_file_close(pc_file *file, pc_context *ctx) {
    if (file->map) (void)munmap(file->map, file->size);
    pc_free(ctx, file->buffer);
    *file = (pc_file){0};
}

/* ---- writing ---- */

enum { BUFFER = 1 << 18 };

static pc_status copy_text(char **copy, pc_context *ctx, const char *text) {
    pc_status status = pc_new(copy, ctx, strlen(text) + 1);
    if (status == PC_OK) memcpy(*copy, text, strlen(text) + 1);
    return status;
}

/* The place itself where `path` is a link, so that the link stays one; refused where nothing may be put
 * there. */
static pc_status resolve(char **place, pc_context *ctx, const char *path, bool force) {
    struct stat about;
    *place = NULL;
    if (stat(path, &about) != 0) return copy_text(place, ctx, path);
    if (!S_ISREG(about.st_mode) || !force) {
        const char *why = S_ISREG(about.st_mode) ? "exists already; --force overwrites it"
                                                 : "exists and is not a regular file";
        (void)pc_fail(ctx, PC_E_IO, "%s: %s", path, why);
        return PC_E_IO;
    }
    char *real = realpath(path, NULL);
    pc_status status = copy_text(place, ctx, real ? real : path);
    free(real);
    return status;
}

static pc_status temporary_beside(char **temporary, pc_context *ctx, const char *place) {
    static atomic_uint serial;
    const char *slash = strrchr(place, '/');
    int folder = slash ? (int)(slash - place) + 1 : 0;
    size_t room = strlen(place) + 48;
    pc_status status = pc_new(temporary, ctx, room);
    if (status == PC_OK)
        (void)snprintf(*temporary, room, "%.*s.%s.%ld-%u.tmp", folder, place, place + folder, (long)getpid(),
                       atomic_fetch_add(&serial, 1));
    return status;
}

/* So that the name itself is on the disk. Some file systems cannot do that: the content is safe by then. */
static void sync_folder(const char *folder) {
    int descriptor = open(folder, O_DIRECTORY | O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return;
    (void)fsync(descriptor);
    (void)close(descriptor);
}

static pc_status folder_of(char **folder, pc_context *ctx, const char *path) {
    const char *slash = strrchr(path, '/');
    pc_status status = copy_text(folder, ctx, slash ? path : ".");
    if (status == PC_OK && slash) (*folder)[slash == path ? 1 : slash - path] = '\0';
    return status;
}

/* Without force a link is made, which fails where somebody has put a file there meanwhile. Nothing fails once
 * the file stands in its place. */
static pc_status put_in_place(pc_context *ctx, const char *temporary, const char *place, bool force) {
    char *folder = NULL;
    pc_status status = folder_of(&folder, ctx, place);
    if (status != PC_OK) return status;
    if (!force && link(temporary, place) == 0)
        (void)unlink(temporary);
    else if (!force && errno == EEXIST)
        status = pc_fail(ctx, PC_E_IO, "%s: exists already; --force overwrites it", place);
    else if (rename(temporary, place) != 0)
        status = fail_errno(ctx, place, "cannot be put in place");
    if (status == PC_OK) sync_folder(folder);
    pc_free(ctx, folder);
    return status;
}

static void free_writer(pc_writer *writer) {
    pc_free(writer->ctx, writer->path);
    pc_free(writer->ctx, writer->temporary);
    pc_free(writer->ctx, writer->buffer);
    *writer = (pc_writer){0};
}

pc_status pc_writer_open(pc_writer *writer, pc_context *ctx, const char *path, bool force) {
    pc_status status = PC_OK;
    *writer = (pc_writer){.ctx = ctx, .descriptor = -1, .force = force};
    PC_TRY(resolve(&writer->path, ctx, path, force));
    PC_TRY(temporary_beside(&writer->temporary, ctx, writer->path));
    PC_TRY(pc_new(&writer->buffer, ctx, BUFFER));
    writer->descriptor = open(writer->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (writer->descriptor < 0) status = fail_errno(ctx, path, "cannot be written");
done:
    if (status != PC_OK) free_writer(writer);
    return status;
}

static pc_status write_out(pc_writer *writer, const char *data, size_t size) {
    while (size > 0) {
        ssize_t written = write(writer->descriptor, data, size);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return fail_errno(writer->ctx, writer->path, "cannot be written");
        data += written;
        size -= (size_t)written;
    }
    return PC_OK;
}

static pc_status flush(pc_writer *writer) {
    pc_status status = write_out(writer, writer->buffer, writer->used);
    writer->used = 0;
    return status;
}

pc_status pc_writer_put(pc_writer *writer, const void *data, size_t size) {
    pc_status status = PC_OK;
    if (size > BUFFER - writer->used) PC_TRY(flush(writer));
    if (size > BUFFER) return write_out(writer, data, size);
    memcpy(writer->buffer + writer->used, data, size);
    writer->used += size;
done:
    return status;
}

pc_status pc_writer_commit(pc_writer *writer) {
    pc_status status = PC_OK;
    PC_TRY(flush(writer));
    if (fsync(writer->descriptor) != 0)
        PC_TRY(fail_errno(writer->ctx, writer->path, "cannot be synced to the disk"));
    int closed = close(writer->descriptor);
    writer->descriptor = -1;
    if (closed != 0) PC_TRY(fail_errno(writer->ctx, writer->path, "cannot be written"));
    PC_TRY(put_in_place(writer->ctx, writer->temporary, writer->path, writer->force));
    free_writer(writer);
done:
    if (status != PC_OK) pc_writer_abandon(writer);
    return status;
}

void pc_writer_abandon(pc_writer *writer) {
    if (!writer->ctx) return;
    if (writer->descriptor >= 0) (void)close(writer->descriptor);
    if (writer->temporary) (void)unlink(writer->temporary);
    free_writer(writer);
}
