#include "sha256.h"
#include <string.h>

/* The first 32 bits of the fractional parts of the cube roots of the first 64 primes. */
static const uint32_t round_constant[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

static uint32_t turned(uint32_t x, int bits) {
    return (x >> bits) | (x << (32 - bits));
}

/* One round with the roles of the eight variables rotated by the caller, so that nothing has to be moved. */
static inline void one_round(uint32_t a, uint32_t b, uint32_t c, uint32_t *d, uint32_t e, uint32_t f,
                             uint32_t g, uint32_t *h, uint32_t input) {
    uint32_t sum = *h + (turned(e, 6) ^ turned(e, 11) ^ turned(e, 25)) + (g ^ (e & (f ^ g))) + input;
    *d += sum;
    *h = sum + (turned(a, 2) ^ turned(a, 13) ^ turned(a, 22)) + ((a & b) | (c & (a | b)));
}

static void add_block(uint32_t state[8], const unsigned char *block) {
    uint32_t w[64];
    for (int i = 0; i < 16; i++)
        w[i] = (uint32_t)block[4 * i] << 24 | (uint32_t)block[4 * i + 1] << 16 |
               (uint32_t)block[4 * i + 2] << 8 | (uint32_t)block[4 * i + 3];
    for (int i = 16; i < 64; i++) {
        uint32_t low = turned(w[i - 15], 7) ^ turned(w[i - 15], 18) ^ (w[i - 15] >> 3);
        uint32_t high = turned(w[i - 2], 17) ^ turned(w[i - 2], 19) ^ (w[i - 2] >> 10);
        w[i] = w[i - 16] + low + w[i - 7] + high;
    }
    uint32_t a = state[0], b = state[1], c = state[2], d = state[3];
    uint32_t e = state[4], f = state[5], g = state[6], h = state[7];
    for (int i = 0; i < 64; i += 8) {
        const uint32_t *k = round_constant + i, *v = w + i;
        one_round(a, b, c, &d, e, f, g, &h, k[0] + v[0]);
        one_round(h, a, b, &c, d, e, f, &g, k[1] + v[1]);
        one_round(g, h, a, &b, c, d, e, &f, k[2] + v[2]);
        one_round(f, g, h, &a, b, c, d, &e, k[3] + v[3]);
        one_round(e, f, g, &h, a, b, c, &d, k[4] + v[4]);
        one_round(d, e, f, &g, h, a, b, &c, k[5] + v[5]);
        one_round(c, d, e, &f, g, h, a, &b, k[6] + v[6]);
        one_round(b, c, d, &e, f, g, h, &a, k[7] + v[7]);
    }
    state[0] += a, state[1] += b, state[2] += c, state[3] += d;
    state[4] += e, state[5] += f, state[6] += g, state[7] += h;
}

void pc_sha256_start(pc_sha256 *hash) {
    *hash = (pc_sha256){.state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c,
                                  0x1f83d9ab, 0x5be0cd19}};
}

void pc_sha256_add(pc_sha256 *hash, const void *bytes, size_t count) {
    const unsigned char *from = bytes;
    size_t held = hash->bytes % 64;
    hash->bytes += count;
    while (count > 0) {
        if (held == 0 && count >= 64) {
            add_block(hash->state, from);
            from += 64, count -= 64;
            continue;
        }
        size_t part = 64 - held < count ? 64 - held : count;
        memcpy(hash->block + held, from, part);
        held += part, from += part, count -= part;
        if (held < 64) return;
        add_block(hash->state, hash->block);
        held = 0;
    }
}

void pc_sha256_add_text(pc_sha256 *hash, const char *text) {
    uint64_t length = strlen(text);
    unsigned char bytes[8];
    for (int i = 0; i < 8; i++)
        bytes[i] = (unsigned char)(length >> 8 * i);
    pc_sha256_add(hash, bytes, sizeof bytes);
    pc_sha256_add(hash, text, length);
}

void pc_sha256_finish(char text[PC_SHA256_TEXT], pc_sha256 *hash) {
    uint64_t bits = hash->bytes * 8;
    unsigned char tail[72] = {0x80};
    size_t zeros = (hash->bytes % 64 < 56 ? 56 : 120) - hash->bytes % 64;
    for (int i = 0; i < 8; i++)
        tail[zeros + (size_t)i] = (unsigned char)(bits >> (56 - 8 * i));
    pc_sha256_add(hash, tail, zeros + 8);
    for (int i = 0; i < 64; i++)
        text[i] = "0123456789abcdef"[hash->state[i / 8] >> (28 - 4 * (i % 8)) & 15];
    text[64] = '\0';
}
