#pragma once
/* A file that a command writes. It appears under its name whole or not at all. A device, a pipe or
 * any other name that is no regular file is written to and never replaced. */
#include <stdbool.h>
#include <stdio.h>

#include "proto/error.h"

struct output_file {
    FILE *file;       /* to write to, and to read back from */
    const char *path; /* borrowed */
    char part[4096];  /* where the bytes are until it is closed; empty: in a file without name */
};

/* Checks that the file could be written now, before the work that fills it. ERR_IO. */
int output_file_check(const char *path, struct fault *fault);

/* Does the same for a picture in the format `ending`, "exr" or "png". ERR_RANGE, too, where the
 * name ends as pictures of another format do, whose programs could not open it. */
int output_file_check_picture(const char *path, const char *ending, struct fault *fault);

/* Checks that no two of the paths, some of which may be NULL, name one file, which would keep
 * only what is written last. ERR_EXISTS. */
int output_files_check_apart(const char *const *paths, size_t count, struct fault *fault);

int output_file_open(struct output_file *o, const char *path, struct fault *fault);

/* Closes the file. keep: it gets its name; else nothing stays. */
int output_file_close(struct output_file *o, bool keep, struct fault *fault);
