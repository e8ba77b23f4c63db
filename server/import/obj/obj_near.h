#pragma once
/* Vertices that are written far from their origin, as surveys and scans have them. Their text has
 * more digits than a float, so it is counted from the middle of the scene before assimp reads it.
 */
#include "server/import/fence/files.h"

struct obj_near {
    struct file_view view; /* the text to read: the file's own, or `text` */
    char *text;            /* owned; NULL: the vertices are near */
    double origin[3];      /* what was taken from them */
};

/* `main` is borrowed. ERR_MEMORY. */
int obj_near_open(struct obj_near *near, const char *name, const struct file_view *main,
                  struct fault *fault);
void obj_near_close(struct obj_near *near);
