#pragma once
/* assimp's view of the file system: the main file, in memory. It finds no library, so that it keeps
 * no more than the names of materials; mtl.h reads these. */
#include <assimp/cfileio.h>

#include "server/import/fence/files.h"

struct obj_io {
    const char *alias;            /* what assimp believes the main file is called */
    const struct file_view *main; /* borrowed */
    struct aiFileIO callbacks;    /* to hand to assimp; UserData points to this struct */
};

void obj_io_init(struct obj_io *io, const char *alias, const struct file_view *main);
