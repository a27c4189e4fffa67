#include "folder.h"
#include "memory.h"
#include "run.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* Everything that an export writes. */
static const char *const results[] = {
    PC_OUT_RESULT,
    PC_OUT_REPORT,
    PC_OUT_PAGE,
    "quads.obj",
    "quads.ply",
    "quads.hdf",
    "scan.hdf",
    "scan.png",
    "field.png",
    "curvature.png",
    "isolines.png",
    "quads.png",
    "layout.png",
    "surface.png",
    "zebra.png",
    "error.png",
    PC_OUT_SURFACE ".step",
    PC_OUT_SURFACE ".hdf",
    PC_OUT_SURFACE ".igs",
    PC_OUT_SURFACE ".iga",
    PC_OUT_SURFACE ".bext",
    PC_OUT_SURFACE ".xml",
    PC_OUT_CAGE,
};

pc_status pc_folder_join(char **path, pc_context *ctx, const char *folder, const char *name,
                         const char *ending) {
    size_t size = strlen(folder) + strlen(name) + strlen(ending) + 2;
    *path = NULL;
    pc_status status = pc_new(path, ctx, size);
    if (status != PC_OK) return status;
    (void)snprintf(*path, size, "%s/%s%s", folder, name, ending);
    return PC_OK;
}

static pc_status make_one(pc_context *ctx, const char *path) {
    if (mkdir(path, 0777) == 0 || errno == EEXIST || errno == EISDIR) return PC_OK;
    return pc_fail(ctx, PC_E_IO, "%s: the folder cannot be made: %s", path, strerror(errno));
}

static pc_status make_with_parents(pc_context *ctx, const char *folder) {
    char *path = NULL;
    pc_status status = PC_OK;
    PC_TRY(pc_folder_join(&path, ctx, folder, "", ""));
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        PC_TRY(make_one(ctx, path));
        *slash = '/';
    }
done:
    pc_free(ctx, path);
    return status;
}

static pc_status count_entries(size_t *count, bool *has_stages, bool *exists, pc_context *ctx,
                               const char *folder) {
    *count = 0;
    *has_stages = false;
    DIR *directory = opendir(folder);
    *exists = directory || errno != ENOENT;
    if (!*exists) return PC_OK;
    if (!directory && errno == ENOTDIR)
        return pc_fail(ctx, PC_E_USAGE, "%s: is a file; -o wants the name of a folder", folder);
    if (!directory) return pc_fail(ctx, PC_E_IO, "%s: cannot be read: %s", folder, strerror(errno));
    for (struct dirent *entry = readdir(directory); entry; entry = readdir(directory)) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
        (*count)++;
        if (strcmp(entry->d_name, PC_OUT_STAGES) == 0) *has_stages = true;
    }
    (void)closedir(directory);
    return PC_OK;
}

static pc_status remove_file(pc_context *ctx, const char *folder, const char *name, const char *ending) {
    char *path = NULL;
    pc_status status = pc_folder_join(&path, ctx, folder, name, ending);
    if (status == PC_OK && unlink(path) != 0 && errno != ENOENT)
        status = pc_fail(ctx, PC_E_IO, "%s: cannot be removed: %s", path, strerror(errno));
    pc_free(ctx, path);
    return status;
}

static pc_status remove_earlier(pc_context *ctx, const char *folder, const char *stages, bool resume) {
    pc_status status = PC_OK;
    for (size_t i = 0; i < sizeof results / sizeof *results; i++)
        PC_TRY(remove_file(ctx, folder, results[i], ""));
    for (int stage = 0; !resume && stage < PC_STAGE_EXPORT; stage++)
        PC_TRY(remove_file(ctx, stages, pc_stage_title((pc_stage_id)stage), ".h5"));
done:
    return status;
}

static pc_status take_lock(int *lock, pc_context *ctx, const char *folder) {
    *lock = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (*lock < 0 || flock(*lock, LOCK_EX | LOCK_NB) == 0) return PC_OK;
    bool taken = errno == EWOULDBLOCK;
    (void)close(*lock);
    *lock = -1;
    if (!taken) return PC_OK;
    return pc_fail(ctx, PC_E_USAGE, "%s: another run is at work there; wait for it, or choose another folder",
                   folder);
}

void pc_folder_release(pc_folder *held, pc_context *ctx, bool failed) {
    char *stages = NULL;
    if (!held->ready) return;
    /* Folders that hold anything stay: rmdir refuses them. */
    if (failed && pc_folder_join(&stages, ctx, held->path, PC_OUT_STAGES, "") == PC_OK) {
        (void)rmdir(stages);
        if (held->made) (void)rmdir(held->path);
    }
    pc_free(ctx, stages);
    if (held->lock >= 0) (void)close(held->lock);
    held->ready = false;
}

pc_status pc_folder_prepare(pc_folder *held, pc_context *ctx, const char *folder, bool resume, bool force) {
    size_t count;
    bool has_stages, exists;
    char *stages = NULL;
    pc_status status = PC_OK;
    *held = (pc_folder){.path = folder, .lock = -1};
    PC_TRY(count_entries(&count, &has_stages, &exists, ctx, folder));
    held->made = !exists;
    if (count > 0 && !force && !(resume && has_stages)) {
        status =
            pc_fail(ctx, PC_E_USAGE,
                    resume ? "%s: is not empty and holds no earlier run to resume; choose another folder, or "
                             "--force to overwrite"
                           : "%s: exists and is not empty; --resume continues an earlier run there, --force "
                             "overwrites its results",
                    folder);
        goto done;
    }
    PC_TRY(make_with_parents(ctx, folder));
    PC_TRY(take_lock(&held->lock, ctx, folder));
    held->ready = true;
    PC_TRY(pc_folder_join(&stages, ctx, folder, PC_OUT_STAGES, ""));
    PC_TRY(make_one(ctx, stages));
    PC_TRY(remove_earlier(ctx, folder, stages, resume));
done:
    pc_free(ctx, stages);
    return status;
}
