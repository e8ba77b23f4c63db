#pragma once
/* Turns an .hdr or .exr file into an environment blob.
 *
 *   files  ->  panorama (radiance or exr, repaired)  ->  blob_writer  ->  environment_map
 */
#include "server/import/image/panorama.h"
#include "server/import/scene/import_stats.h"

/* Returns whether a file is known, by its first bytes and not by its name. */
bool environment_is_known(const struct file_view *file);

/* Imports a file that environment_is_known knows and writes the blob to `out`. A failure leaves no
 * part of a blob behind. */
int environment_import(const struct file_view *file, const char *name, const char *out,
                       struct warnings *warnings, struct import_stats *stats, struct fault *fault);
