#pragma once
/* Turns a scene file into a scene blob. Environment maps have a path of their own
 * (environment_import.h).
 *
 *   files, gltf_* or obj_*  ->  builder  ->  emitters, cameras  ->  blob_writer  ->  scene_map
 */
#include "server/import/scene/builder.h"
#include "server/import/scene/import_stats.h"
#include "server/import/scene/scene_choice.h"

/* Imports `name` beneath the directory `root`, a scene or (recognised by its first bytes) an
 * environment map, as chosen, and writes the blob to `out`, which is checked by opening it before
 * this returns. With times a scene that moves becomes a base in `out` and frames in `out`.0,
 * `out`.1, ..., as many as stats->frames says: those that there is time for, the first in any case.
 * A failure leaves no part of a blob behind. *warnings is filled in in both cases. */
int import_scene(const char *root, const char *name, const struct scene_choice *choice,
                 const char *out, struct warnings *warnings, struct import_stats *stats,
                 struct fault *fault);
