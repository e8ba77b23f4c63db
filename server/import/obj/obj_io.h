#pragma once
/* assimp's view of the file system: the files beneath the scene's root, read-only, in memory. */
#include <assimp/cfileio.h>
#include <stdbool.h>

#include "server/import/fence/files.h"

struct obj_io {
    struct files *files;          /* borrowed */
    const char *alias;            /* what assimp believes the main file is called */
    const struct file_view *main; /* borrowed */
    bool failed;                  /* a file was asked for in vain; fault has the first */
    struct fault fault;
    struct aiFileIO callbacks; /* to hand to assimp; UserData points to this struct */
};

void obj_io_init(struct obj_io *io, struct files *files, const char *alias,
                 const struct file_view *main);
