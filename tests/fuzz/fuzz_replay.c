/* Runs a reader on every file of some folders and on seeded mutations of each: replay FOLDER... */
#include "fuzz_target.h"
#include "random.h"
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { MUTATIONS = 1500, LARGEST = 1 << 20 };

static const char *const words[] = {
    "-1", "nan", "99999999999",      "4294967295", "1e999",   "\\\n",   "\r", "\n",         "#",    "/",
    " ",  "0",   "\xff\xff\xff\xff", "\x7f\xf0",   "element", "vertex", "f",  "end_header", "solid"};

/* Flipped bytes, cut or repeated stretches, words where they do not belong. */
static size_t mutate(uint8_t *data, size_t size, pc_random *random) {
    size_t rounds = 1 + pc_random_next(random) % 4;
    for (size_t i = 0; i < rounds && size > 0; i++) {
        size_t at = pc_random_next(random) % size;
        size_t length = 1 + pc_random_next(random) % 16;
        uint64_t dice = pc_random_next(random);
        const char *word = words[(dice >> 8) % (sizeof words / sizeof *words)];
        switch (dice % 6) {
        case 0:
            data[at] = (uint8_t)(dice >> 16);
            break;
        case 1:
            data[at] ^= (uint8_t)(1U << (dice >> 16) % 8);
            break;
        case 2:
            size = at;
            break;
        case 3:
            for (size_t k = 0; word[k] && at + k < size; k++)
                data[at + k] = (uint8_t)word[k];
            break;
        case 4:
            if (length > size - at) length = size - at;
            memmove(data + at, data + at + length, size - at - length);
            size -= length;
            break;
        default:
            if (length > size - at) length = size - at;
            memmove(data + at + length, data + at, size - at);
            size += length;
        }
    }
    return size;
}

/* The bytes stand in a block of their exact size, so that a sanitizer sees the first one behind them. */
static void run(const uint8_t *data, size_t size) {
    uint8_t *copy = malloc(size ? size : 1);
    if (!copy) exit(2);
    memcpy(copy, data, size);
    (void)LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

static void replay(const uint8_t *seed, size_t size, uint64_t number) {
    static uint8_t data[LARGEST + 256];
    run(seed, size);
    for (uint64_t i = 0; i < MUTATIONS; i++) {
        pc_random random = {pc_hash64(number) + i};
        memcpy(data, seed, size);
        run(data, mutate(data, size, &random));
    }
}

static int replay_file(const char *path) {
    static uint8_t seed[LARGEST];
    FILE *file = fopen(path, "rb");
    if (!file) return 0;
    size_t size = fread(seed, 1, sizeof seed, file);
    (void)fclose(file);
    uint64_t number = 0;
    for (size_t i = 0; i < size; i++)
        number = pc_hash64(number ^ seed[i]);
    replay(seed, size, number);
    return 1;
}

int main(int argc, char **argv) {
    int files = 0;
    for (int i = 1; i < argc; i++) {
        DIR *folder = opendir(argv[i]);
        if (!folder) {
            perror(argv[i]);
            return 1;
        }
        for (struct dirent *entry; (entry = readdir(folder));) {
            char path[4096];
            struct stat about;
            (void)snprintf(path, sizeof path, "%s/%s", argv[i], entry->d_name);
            if (stat(path, &about) == 0 && S_ISREG(about.st_mode)) files += replay_file(path);
        }
        (void)closedir(folder);
    }
    (void)printf("%d files, each with %d mutations\n", files, MUTATIONS);
    return files > 0 ? 0 : 1;
}
