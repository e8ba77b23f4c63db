#pragma once
/* The one line of JSON that tells the coordinator how an import went. */
#include "server/import/import.h"

/* Writes {"ok":true,"triangles":..,"placed_triangles":..,"frames":..,"warnings":[..],"cpu_s":..}
 * with a line end. An environment map has "width_px" and "height_px" instead of triangles. The
 * caller frees it; NULL on failed allocation. */
char *report_success(const struct import_stats *stats, const struct warnings *warnings,
                     double cpu_s);

/* Writes {"ok":false,"code":"TRUNCATED","pointer":"..","detail":".."} with a line end. */
char *report_failure(const struct fault *fault);
