/* SHA-256 (FIPS 180-4): names for inputs and keys for stages. */
#ifndef PC_SHA256_H
#define PC_SHA256_H

#include <stddef.h>
#include <stdint.h>

typedef struct pc_sha256 {
    uint32_t state[8];
    uint64_t bytes;
    unsigned char block[64];
} pc_sha256;

enum { PC_SHA256_TEXT = 65 }; /* 64 lower-case hexadecimal digits and the final 0 */

void pc_sha256_start(pc_sha256 *hash);
void pc_sha256_add(pc_sha256 *hash, const void *bytes, size_t count);
/* Adds a text and its length, so that ("ab","c") and ("a","bc") differ. */
void pc_sha256_add_text(pc_sha256 *hash, const char *text);
/* The digest as text; `hash` must be started again before further use. */
void pc_sha256_finish(char text[PC_SHA256_TEXT], pc_sha256 *hash);

#endif
