#include "seal.h"
#include "memory.h"
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <libdeflate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* "\npercale seal <16 hex digits: length> <8 hex digits: CRC-32>\n" */
enum { SEAL_BYTES = 40, BUFFER_BYTES = 1 << 20 };
static const char seal_format[] = "\npercale seal %016" PRIx64 " %08" PRIx32 "\n";

static pc_status system_failed(pc_context *ctx, const char *what, const char *path) {
    return pc_fail(ctx, PC_E_IO, "%s: cannot %s: %s", path, what, strerror(errno));
}

/* The checksum of the next `bytes` bytes of `file`. */
static pc_status checksum(uint32_t *crc, pc_context *ctx, int file, uint64_t bytes, const char *path) {
    pc_status status = PC_OK;
    unsigned char *buffer = NULL;
    *crc = 0;
    PC_TRY(pc_new(&buffer, ctx, BUFFER_BYTES));
    while (bytes > 0) {
        size_t want = bytes < BUFFER_BYTES ? (size_t)bytes : BUFFER_BYTES;
        ssize_t got = read(file, buffer, want);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) PC_TRY(system_failed(ctx, "read", path));
        if (got == 0) PC_TRY(pc_fail(ctx, PC_E_FORMAT, "%s: the file became shorter while being read", path));
        *crc = libdeflate_crc32(*crc, buffer, (size_t)got);
        bytes -= (uint64_t)got;
        PC_TRY(pc_check_interrupt(ctx));
    }
done:
    pc_free(ctx, buffer);
    return status;
}

pc_status pc_seal_write(pc_context *ctx, const char *path) {
    pc_status status = PC_OK;
    char seal[SEAL_BYTES + 1];
    uint32_t crc;
    struct stat info;
    int file = open(path, O_RDWR | O_CLOEXEC);
    if (file < 0) PC_TRY(system_failed(ctx, "open the file", path));
    if (fstat(file, &info) != 0) PC_TRY(system_failed(ctx, "examine the file", path));
    PC_TRY(checksum(&crc, ctx, file, (uint64_t)info.st_size, path));
    (void)snprintf(seal, sizeof seal, seal_format, (uint64_t)info.st_size, crc);
    for (size_t done = 0; done < SEAL_BYTES;) {
        ssize_t put = write(file, seal + done, SEAL_BYTES - done);
        if (put < 0 && errno != EINTR) PC_TRY(system_failed(ctx, "write", path));
        if (put > 0) done += (size_t)put;
    }
    if (fsync(file) != 0) PC_TRY(system_failed(ctx, "flush", path));
done:
    if (file >= 0 && close(file) != 0 && status == PC_OK) status = system_failed(ctx, "close", path);
    return status;
}

/* The length and checksum that the last bytes of the file promise. */
static pc_status read_seal(uint64_t *bytes, uint32_t *crc, pc_context *ctx, int file, const char *path) {
    char seal[SEAL_BYTES + 1] = {0}, again[SEAL_BYTES + 1];
    struct stat info;
    if (fstat(file, &info) != 0) return system_failed(ctx, "examine the file", path);
    if (!S_ISREG(info.st_mode)) return pc_fail(ctx, PC_E_FORMAT, "%s: not a regular file", path);
    off_t start = info.st_size - SEAL_BYTES;
    if (start > 0 && pread(file, seal, SEAL_BYTES, start) == SEAL_BYTES) {
        *bytes = (uint64_t)start;
        *crc = (uint32_t)strtoul(seal + SEAL_BYTES - 9, NULL, 16);
        (void)snprintf(again, sizeof again, seal_format, *bytes, *crc);
        if (memcmp(seal, again, SEAL_BYTES) == 0) return PC_OK;
    }
    return pc_fail(ctx, PC_E_FORMAT,
                   "%s: not a file of Percale, or cut off, or changed since (its last line is not the seal)",
                   path);
}

pc_status pc_seal_check(uint64_t *bytes, pc_context *ctx, const char *path) {
    pc_status status = PC_OK;
    uint32_t promised = 0, crc = 0;
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) PC_TRY(system_failed(ctx, "open the file", path));
    PC_TRY(read_seal(bytes, &promised, ctx, file, path));
    PC_TRY(checksum(&crc, ctx, file, *bytes, path));
    if (crc != promised)
        PC_TRY(pc_fail(ctx, PC_E_FORMAT, "%s: damaged: checksum %08" PRIx32 " instead of %08" PRIx32, path,
                       crc, promised));
done:
    if (file >= 0) (void)close(file);
    return status;
}

pc_status pc_seal_publish(pc_context *ctx, const char *temporary, const char *path) {
    pc_status status = PC_OK;
    char *folder = NULL;
    int file = -1;
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    PC_TRY(pc_new(&folder, ctx, length + 2));
    memcpy(folder, path, length);
    if (length == 0) folder[0] = '.';
    if (rename(temporary, path) != 0) PC_TRY(system_failed(ctx, "give the finished file its name", path));
    file = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    /* Some file systems cannot flush a folder (EINVAL); the file itself is safe by then. */
    if (file >= 0 && fsync(file) != 0 && errno != EINVAL && errno != EROFS)
        PC_TRY(system_failed(ctx, "flush the folder", folder));
done:
    if (file >= 0) (void)close(file);
    pc_free(ctx, folder);
    return status;
}
