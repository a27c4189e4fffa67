/* The version of the program; CMake defines it. */
#ifndef PC_VERSION_H
#define PC_VERSION_H

/* "0.1.0" */
const char *pc_version(void);

#endif
