#pragma once
/* A map_ line of an MTL file: options, then a file's name, which may have spaces. */
#include <stdbool.h>
#include <stddef.h>

#define MTL_OPTION_BYTES 16

struct mtl_map {
    const char *name; /* within the line; "" for none */
    float scale[2], offset[2];
    bool clamp;
    char ignored[MTL_OPTION_BYTES]; /* the first option that changes the picture and is not drawn */
};

/* Reads what stands behind the keyword. Writes into `line`: the name loses white space at its end,
 * quotes around it, and backslashes, which become slashes. */
void mtl_map_read(char *line, struct mtl_map *out);

/* Cleans a file's name as mtl_map_read does; returns where it begins. */
char *mtl_name_clean(char *name);

/* Returns under which name a file is looked for: writers name folders of their own machine, and
 * then the file is taken that lies beside the scene. */
const char *mtl_name_beside(const char *name);

/* Steps over a byte order mark at the text's start. */
void mtl_skip_mark(const char **text, size_t *size_bytes);
