#pragma once
/* Relative paths inside a scene. */
#include <stdbool.h>

/* True for a path that stays inside its folder: relative, no empty, "." or ".." part, no backslash,
 * no control character, within LIMIT_PATH_BYTES. */
bool relative_path_is_inside(const char *path);
