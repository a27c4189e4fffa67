/* percale: the command line. Finds the command, runs it, and turns its status into the exit code. */
#include "command.h"
#include "version.h"
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

typedef struct command {
    const char *name;
    pc_command *run;
    const char *summary;
} command;

static const command commands[] = {
    {"convert", pc_command_convert, "turn a scan into a quad control mesh"},
    {"check", pc_command_check, "tell what a scan is like and what repair would do"},
    {"info", pc_command_info, "tell what an HDF5 file of Percale holds"},
    {"render", pc_command_render, "draw a scan or a result as PNG"},
    {"eval", pc_command_eval, "evaluate the spline of a result: points, normals, distances"},
    {"devices", pc_command_devices, "list the OpenCL devices"},
};
enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

static pc_context *signalled; /* the context that a signal interrupts */

/* The second signal finds the default action: it ends the program at once. */
static void on_signal(int number) {
    if (signalled) pc_context_interrupt(signalled);
    (void)signal(number, SIG_DFL);
}

static void catch_signals(pc_context *ctx) {
    struct sigaction action = {.sa_handler = on_signal};
    signalled = ctx;
    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
}

static void print_usage(FILE *out) {
    (void)fprintf(out, "usage: percale COMMAND [OPTIONS] ...\n\n"
                       "Percale turns triangle scans into curvature-aligned quad meshes.\n\n");
    for (int i = 0; i < COMMAND_COUNT; i++)
        (void)fprintf(out, "  %-10s %s\n", commands[i].name, commands[i].summary);
    (void)fprintf(out, "  %-10s %s\n\n", "help", "explain a command: percale help convert");
    (void)fprintf(out, "percale --version prints the version; man percale tells the whole story.\n");
}

static const command *find_command(const char *name) {
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(commands[i].name, name) == 0) return &commands[i];
    return NULL;
}

static pc_status fail_command(pc_context *ctx, const char *name) {
    const char *words[COMMAND_COUNT + 2];
    for (int i = 0; i < COMMAND_COUNT; i++)
        words[i] = commands[i].name;
    words[COMMAND_COUNT] = "help";
    words[COMMAND_COUNT + 1] = NULL;
    const char *nearest = pc_nearest_word(name, words);
    if (nearest) return pc_fail(ctx, PC_E_USAGE, "unknown command '%s'; did you mean %s?", name, nearest);
    return pc_fail(ctx, PC_E_USAGE, "unknown command '%s'; 'percale help' lists them all", name);
}

static pc_status run_help(pc_context *ctx, int argc, const char **argv) {
    if (argc < 2) {
        print_usage(stdout);
        return PC_OK;
    }
    const command *found = find_command(argv[1]);
    if (!found) return fail_command(ctx, argv[1]);
    const char *arguments[] = {found->name, "--help", NULL};
    return found->run(ctx, 2, arguments);
}

static pc_status dispatch(pc_context *ctx, int argc, const char **argv) {
    if (argc < 2) {
        print_usage(stderr);
        return PC_E_USAGE;
    }
    const char *name = argv[1];
    if (strcmp(name, "--version") == 0 || strcmp(name, "-V") == 0) {
        (void)printf("percale %s\n", pc_version());
        return PC_OK;
    }
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) return run_help(ctx, 1, argv);
    if (strcmp(name, "help") == 0) return run_help(ctx, argc - 1, argv + 1);
    if (name[0] == '-')
        return pc_fail(ctx, PC_E_USAGE, "the command comes first: percale COMMAND %s ...; see 'percale help'",
                       name);
    const command *found = find_command(name);
    return found ? found->run(ctx, argc - 1, argv + 1) : fail_command(ctx, name);
}

void pc_command_help(const char *usage, const char *text, const pc_option *table) {
    (void)printf("usage: percale %s\n\n%s\n\n", usage, text);
    pc_options_print(stdout, table);
}

pc_status pc_command_operands(pc_context *ctx, const pc_operands *operands, int count, const char *usage) {
    if (operands->count == count) return PC_OK;
    if (operands->count < count)
        return pc_fail(ctx, PC_E_USAGE, "a file is missing; usage: percale %s", usage);
    return pc_fail(ctx, PC_E_USAGE, "'%s' is one operand too many; usage: percale %s", operands->text[count],
                   usage);
}

/* Threads of OpenMP that wait for work in a loop take the cores from OpenCL's, and from other programs: on a
 * busy machine that costs a factor of ten. Their library reads the setting before main begins, hence the
 * second start. */
static void let_threads_sleep(char **argv) {
    if (getenv("OMP_WAIT_POLICY") || getenv("GOMP_SPINCOUNT")) return;
    if (setenv("OMP_WAIT_POLICY", "passive", 0) == 0) (void)execv("/proc/self/exe", argv);
}

/* Large blocks go back to the system when they are freed. By default the C library keeps more and more of
 * them, and the peak of a conversion grows by half. */
static void give_memory_back(void) {
#ifdef M_MMAP_THRESHOLD
    (void)mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

int main(int argc, char **argv) {
    let_threads_sleep(argv);
    give_memory_back();
    pc_context *ctx = pc_context_make();
    if (!ctx) {
        (void)fprintf(stderr, "percale: out of memory\n");
        return pc_status_exit_code(PC_E_NOMEM);
    }
    catch_signals(ctx);
    pc_status status = dispatch(ctx, argc, (const char **)argv);
    const char *message = pc_context_message(ctx);
    if (status != PC_OK && message[0])
        (void)fprintf(stderr, "percale: %s\n", message);
    else if (status != PC_OK && status != PC_E_USAGE)
        (void)fprintf(stderr, "percale: %s\n", pc_status_name(status));
    signalled = NULL;
    if (fflush(stdout) != 0 && status == PC_OK) {
        (void)fprintf(stderr, "percale: standard output cannot be written\n");
        status = PC_E_IO;
    }
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
