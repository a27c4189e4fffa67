/* Text that came from outside: file names, comments. */
#ifndef PC_UTF8_H
#define PC_UTF8_H

#include <stddef.h>

/* Length of the UTF-8 sequence at `s`, 0 where there is none. */
static inline size_t pc_utf8_length(const unsigned char *s) {
    static const unsigned char least[5][2] = {{0}, {0}, {0xc2, 0x80}, {0xe0, 0x80}, {0xf0, 0x80}};
    size_t n = s[0] < 0x80 ? 1 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : 4;
    if (n == 1) return 1;
    if (s[0] < least[n][0] || s[0] > 0xf4) return 0;
    for (size_t i = 1; i < n; i++)
        if ((s[i] & 0xc0) != 0x80) return 0;
    if ((s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f)) return 0;
    if ((s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f)) return 0;
    return n;
}

#endif
