/* Lists that grow while they are filled. */
#ifndef PC_GROWING_H
#define PC_GROWING_H

#include "memory.h"

/* Makes sure that `more` items fit behind the `count` that `list` holds in its `room`; for functions with
 * `ctx`, `status` and a label done:, as PC_TRY wants them. */
#define PC_GROW(list, count, room, more)                                                                     \
    do {                                                                                                     \
        if ((count) + (more) > (room)) {                                                                     \
            PC_TRY(pc_resize(&(list), ctx, 2 * (room) + (more)));                                            \
            (room) = 2 * (room) + (more);                                                                    \
        }                                                                                                    \
    } while (0)

#endif
