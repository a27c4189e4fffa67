/* Runs a Python script of the source tree: independent readers of our files. */
#ifndef PC_PYTHON_H
#define PC_PYTHON_H

#include "testing.h"
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PYTHON_SKIPS = 77, PYTHON_PATH_BYTES = 512 };

/* `script` below the root of the source tree; this file lies in root/tests. */
static inline void python_path(char path[PYTHON_PATH_BYTES], const char *script) {
    static const char here[] = __FILE__;
    const char *tests = strrchr(here, '/');
    int folder = tests ? (int)(tests - here) : 0;
    assert_true(snprintf(path, PYTHON_PATH_BYTES, "%.*s/../%s", folder, here, script) < PYTHON_PATH_BYTES);
}

/* The script's exit status. PERCALE_PYTHON names another interpreter than the system's. */
static inline int run_python(const char *script, const char *one, const char *two, const char *three) {
    char path[PYTHON_PATH_BYTES];
    const char *python = getenv("PERCALE_PYTHON");
    int status;
    python_path(path, script);
    if (!python) python = "/usr/bin/python3";
    (void)fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        (void)setenv("PYTHONDONTWRITEBYTECODE", "1", 1);
        (void)execlp(python, python, path, one, two, three, (char *)NULL);
        _exit(PYTHON_SKIPS); /* no Python here */
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

#endif
