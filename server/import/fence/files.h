#pragma once
/* Opens every file that a scene names, beneath one root directory.
 *
 * Names are relative, without "..", and may not pass through a symbolic link. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"

struct files {
    int root_fd;
    uint32_t opened; /* how often; LIMIT_SCENE_FILES beside the main file */
};

/* A file's bytes, mapped read-only. data is never NULL. */
struct file_view {
    const uint8_t *data;
    size_t size_bytes;
};

int files_open(struct files *files, const char *root, struct fault *fault);
void files_close(struct files *files);

/* Maps a regular file. `place` is where the scene names it. ERR_NOT_FOUND, ERR_RANGE for a name
 * that leaves the root, ERR_LIMIT, ERR_IO. files_unmap undoes it. */
int files_map(struct files *files, const char *path, const char *place, struct file_view *out,
              struct fault *fault);
void files_unmap(struct file_view *view);

/* Turns a name as written in a scene file into a path beneath the root: joined with the folder of
 * `beside` (a path beneath the root), percent escapes decoded when asked, "." parts dropped.
 * ERR_RANGE when it is absolute, a URL, or leaves the folder. */
int files_resolve(const char *beside, const char *name, bool decode_percent,
                  char out[LIMIT_PATH_BYTES], const char *place, struct fault *fault);
