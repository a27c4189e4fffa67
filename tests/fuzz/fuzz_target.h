/* One entry per reader, for libFuzzer and for the replay: whatever the bytes, a sound mesh or a message. */
#ifndef PC_FUZZ_TARGET_H
#define PC_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif
