#pragma once
/* Relative paths inside a scene. */
#include <stdbool.h>

/* Returns whether a path stays inside its folder: it is relative and within LIMIT_PATH_BYTES, and
 * has no empty, "." or ".." part, no backslash and no control character. */
bool relative_path_is_inside(const char *path);
