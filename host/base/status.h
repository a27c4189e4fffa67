/* Results of calls. Every function that can fail returns a pc_status; out-parameters come first. */
#ifndef PC_STATUS_H
#define PC_STATUS_H

typedef enum pc_status {
    PC_OK = 0,
    PC_E_NOMEM = -1,     /* memory could not be had */
    PC_E_IO = -2,        /* a file cannot be opened, read or written */
    PC_E_FORMAT = -3,    /* a file's content is not what its format demands */
    PC_E_MESH = -4,      /* the mesh cannot be converted: ids and a hint are in the message */
    PC_E_DEVICE = -5,    /* no such device, or the device failed */
    PC_E_NOCONV = -6,    /* a solver or a stated tolerance was missed */
    PC_E_INTERRUPT = -7, /* the user asked to stop */
    PC_E_USAGE = -8,     /* an option or argument makes no sense */
    PC_E_BUG = -9        /* an invariant of ours is broken */
} pc_status;

/* Goes to the one label `done:` of a function when a call fails; `status` is the function's local. */
#define PC_TRY(call)                                                                                         \
    do {                                                                                                     \
        status = (call);                                                                                     \
        if (status != PC_OK) goto done;                                                                      \
    } while (0)

/* The documented exit code of a program that ends with this status. */
int pc_status_exit_code(pc_status status);
const char *pc_status_name(pc_status status);

#endif
