/* Whole files: mapped for reading; written aside and put in place at once, so that nobody meets half a file.
 */
#ifndef PC_FILE_H
#define PC_FILE_H

#include "context.h"

typedef struct pc_file {
    const char *data;
    size_t size;
    void *map;    /* a mapped regular file, */
    void *buffer; /* or what came out of a pipe */
} pc_file;

/* The whole content, mapped where it is a regular file, else read (pipes, devices). PC_E_IO with the reason.
 * The file must not shrink before pc_file_close. */
pc_status pc_file_open(pc_file *file, pc_context *ctx, const char *path);
void pc_file_close(pc_file *file, pc_context *ctx);

/* A file being written under a temporary name beside its place. */
typedef struct pc_writer {
    pc_context *ctx;
    char *path;      /* where it will stand, links resolved */
    char *temporary; /* where it stands now */
    char *buffer;
    size_t used;
    int descriptor;
    bool force;
} pc_writer;

/* PC_E_IO where `path` exists and `force` is false, is not a regular file, or its folder cannot be written
 * to. */
pc_status pc_writer_open(pc_writer *writer, pc_context *ctx, const char *path, bool force);
pc_status pc_writer_put(pc_writer *writer, const void *data, size_t size);
/* Writes, syncs and puts the file in place; frees the writer whether or not that works. */
pc_status pc_writer_commit(pc_writer *writer);
/* Gives up: the temporary file goes, the place stays as it was. Fine after a commit, or on a zeroed writer.
 */
void pc_writer_abandon(pc_writer *writer);

#endif
