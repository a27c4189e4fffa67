/* Programs built from embedded sources, with their binaries kept in the user's cache folder. */
#include "device_private.h"
#include "memory.h"
#include "random.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A cache file: this head, then the binary. */
typedef struct cache_head {
    char magic[8];
    uint64_t key;
    uint64_t bytes;
    uint64_t sum;
} cache_head;

static const char cache_magic[8] = "PCLBIN1";

static uint64_t hash_bytes(uint64_t hash, const void *data, size_t bytes) {
    const unsigned char *p = data;
    for (size_t i = 0; i < bytes; i++)
        hash = (hash ^ p[i]) * 0x100000001b3u;
    return pc_hash64(hash ^ bytes);
}

static uint64_t hash_text(uint64_t hash, const char *text) {
    return hash_bytes(hash, text, strlen(text));
}

static uint64_t program_key(const pc_device *d, const char *source, const char *options) {
    uint64_t key = hash_text(0xcbf29ce484222325u, source);
    key = hash_text(key, options);
    key = hash_text(key, d->info.platform_name);
    key = hash_text(key, d->info.version);
    key = hash_text(key, d->info.driver);
    return hash_text(key, d->info.name);
}

/* False where there is no home: programs are then built each time. */
static bool cache_path(char *path, size_t size, uint64_t key, bool make) {
    const char *root = getenv("XDG_CACHE_HOME");
    const char *below = "";
    if (!root || root[0] != '/') {
        root = getenv("HOME");
        below = "/.cache";
    }
    if (!root || root[0] != '/') return false;
    int n = snprintf(path, size, "%s%s", root, below);
    if (n < 0 || (size_t)n + 40 > size) return false;
    if (make && mkdir(path, 0700) != 0 && errno != EEXIST) return false;
    memcpy(path + n, "/percale", 9);
    if (make && mkdir(path, 0700) != 0 && errno != EEXIST) return false;
    (void)snprintf(path + n + 8, size - (size_t)n - 8, "/%016llx.clbin", (unsigned long long)key);
    return true;
}

/* The cached binary, or NULL where there is none that is whole. */
static unsigned char *load_binary(size_t *bytes, pc_context *ctx, uint64_t key) {
    char path[1024];
    cache_head head;
    unsigned char *binary = NULL;
    if (!cache_path(path, sizeof path, key, false)) return NULL;
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    struct stat stat_of;
    bool good = fread(&head, sizeof head, 1, file) == 1 && fstat(fileno(file), &stat_of) == 0 &&
                memcmp(head.magic, cache_magic, sizeof head.magic) == 0 && head.key == key &&
                head.bytes > 0 && (uint64_t)stat_of.st_size == sizeof head + head.bytes;
    if (good && pc_new(&binary, ctx, head.bytes) == PC_OK) {
        good = fread(binary, 1, head.bytes, file) == head.bytes &&
               hash_bytes(key, binary, head.bytes) == head.sum;
        *bytes = head.bytes;
    }
    (void)fclose(file);
    if (!good) {
        pc_free(ctx, binary);
        binary = NULL;
    }
    return binary;
}

static bool write_all(int file, const void *data, size_t bytes) {
    const char *p = data;
    while (bytes > 0) {
        ssize_t n = write(file, p, bytes);
        if (n <= 0) return false;
        p += n;
        bytes -= (size_t)n;
    }
    return true;
}

/* Failure is no error: the next run builds again. */
static void store_binary(uint64_t key, const unsigned char *binary, size_t bytes) {
    char path[1024];
    char temporary[1100];
    if (!cache_path(path, sizeof path, key, true)) return;
    (void)snprintf(temporary, sizeof temporary, "%s.%ld", path, (long)getpid());
    int file = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0) return;
    cache_head head = {.key = key, .bytes = bytes, .sum = hash_bytes(key, binary, bytes)};
    memcpy(head.magic, cache_magic, sizeof head.magic);
    bool good = write_all(file, &head, sizeof head) && write_all(file, binary, bytes);
    good = close(file) == 0 && good;
    if (!good || rename(temporary, path) != 0) (void)unlink(temporary);
}

static void store_program(const pc_program *program, pc_context *ctx) {
    size_t bytes = 0;
    unsigned char *binary = NULL;
    if (clGetProgramInfo(program->handle, CL_PROGRAM_BINARY_SIZES, sizeof bytes, &bytes, NULL) !=
            CL_SUCCESS ||
        bytes == 0 || pc_new(&binary, ctx, bytes) != PC_OK)
        return;
    if (clGetProgramInfo(program->handle, CL_PROGRAM_BINARIES, sizeof(unsigned char *), &binary, NULL) ==
        CL_SUCCESS)
        store_binary(program->key, binary, bytes);
    pc_free(ctx, binary);
}

static bool build_from_cache(pc_program *program, pc_context *ctx, const pc_device *device) {
    size_t bytes = 0;
    cl_int error = CL_SUCCESS;
    cl_int of_binary = CL_SUCCESS;
    unsigned char *binary = load_binary(&bytes, ctx, program->key);
    if (!binary) return false;
    const unsigned char *view = binary;
    program->handle =
        clCreateProgramWithBinary(device->context, 1, &device->id, &bytes, &view, &of_binary, &error);
    bool good = error == CL_SUCCESS && of_binary == CL_SUCCESS &&
                clBuildProgram(program->handle, 1, &device->id, program->options, NULL, NULL) == CL_SUCCESS;
    if (!good && program->handle) {
        (void)clReleaseProgram(program->handle);
        program->handle = NULL;
    }
    pc_free(ctx, binary);
    return good;
}

static pc_status build_from_source(pc_program *program, pc_context *ctx, const pc_device *device) {
    cl_int error = CL_SUCCESS;
    const char *source = program->source;
    program->handle = clCreateProgramWithSource(device->context, 1, &source, NULL, &error);
    if (error != CL_SUCCESS) return pc_device_fail(ctx, error, "a kernel source is refused");
    error = clBuildProgram(program->handle, 1, &device->id, program->options, NULL, NULL);
    program->fresh = true;
    if (error == CL_SUCCESS) return PC_OK;
    char log[1500] = "";
    size_t length = 0;
    char *whole = NULL;
    (void)clGetProgramBuildInfo(program->handle, device->id, CL_PROGRAM_BUILD_LOG, 0, NULL, &length);
    if (length > 0 && pc_new(&whole, ctx, length + 1) == PC_OK &&
        clGetProgramBuildInfo(program->handle, device->id, CL_PROGRAM_BUILD_LOG, length, whole, NULL) ==
            CL_SUCCESS)
        (void)snprintf(log, sizeof log, "%s", whole);
    pc_free(ctx, whole);
    return pc_fail(ctx, PC_E_DEVICE, "kernels do not build on '%s' (OpenCL %d): %s", device->info.name,
                   (int)error, log);
}

pc_status pc_program_get(pc_program **program, pc_context *ctx, pc_device *device, const char *source) {
    char options[96];
    pc_program *p = NULL;
    *program = NULL;
    if (device->host) return pc_fail(ctx, PC_E_BUG, "the host device runs no kernels");
    (void)snprintf(options, sizeof options, "-cl-std=CL1.2 -DPC_CHUNK=%d%s", device->shape == PC_SHAPE_CHUNK,
                   device->info.doubles ? " -DPC_DOUBLE=1" : "");
    for (p = device->programs; p; p = p->next) {
        if (p->source == source && strcmp(p->options, options) == 0) {
            *program = p;
            return PC_OK;
        }
    }
    pc_status status = pc_new(&p, ctx, 1);
    if (status != PC_OK) return status;
    p->source = source;
    memcpy(p->options, options, sizeof options);
    p->key = program_key(device, source, options);
    if (!build_from_cache(p, ctx, device)) status = build_from_source(p, ctx, device);
    if (status != PC_OK) {
        if (p->handle) (void)clReleaseProgram(p->handle);
        pc_free(ctx, p);
        return status;
    }
    p->next = device->programs;
    device->programs = p;
    *program = p;
    return PC_OK;
}

void pc_program_free_all(pc_device *device, pc_context *ctx) {
    while (device->programs) {
        pc_program *p = device->programs;
        /* PoCL's binaries hold the variants that ran, so they are stored at the end. */
        if (p->fresh) store_program(p, ctx);
        while (p->kernels) {
            pc_kernel *k = p->kernels;
            p->kernels = k->next;
            (void)clReleaseKernel(k->handle);
            pc_free(ctx, k);
        }
        (void)clReleaseProgram(p->handle);
        device->programs = p->next;
        pc_free(ctx, p);
    }
}
