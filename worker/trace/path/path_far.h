#pragma once
/* The far sides of translucent surfaces. Light that falls on them comes out on the near side, where
 * the path is: light samples are taken there as well as here. */
#include "worker/trace/path/path.h"

/* Makes *far the lanes of *v that are translucent, seen from behind: there normals face away from
 * the path, and rays start behind the surface. Returns whether there are any. */
bool path_far_find(const struct path_vertex *v, struct path_vertex *far);
