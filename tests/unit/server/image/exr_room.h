#pragma once
/* A folder for each test of EXR files. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/image/exr.h"
#include "tests/unit/unit.h"

static char dir[64];

static inline int make_dir(void **state)
{
    (void)state;
    strcpy(dir, "/tmp/shearwater-exr-XXXXXX");
    return mkdtemp(dir) ? 0 : -1;
}

static inline int remove_dir(void **state)
{
    char command[96];
    (void)state;
    snprintf(command, sizeof command, "rm -r '%s'", dir);
    return system(command);
}

static inline const char *path_of(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", dir, name);
    return path;
}

static inline struct image *read_back(const char *path)
{
    struct image *image;
    struct fault fault = {0};
    if (exr_read(path, &image, &fault)) fail_msg("%s: %s", fault.pointer, fault.detail);
    return image;
}
