#pragma once
/* From a scene file to a scene blob: the way through this room.
 *
 *   files, gltf_* or obj_*  ->  builder  ->  emitters, cameras  ->  blob_writer  ->  scene_map
 */
#include "server/import/builder.h"

struct import_stats {
    uint64_t triangles;        /* stored */
    uint64_t placed_triangles; /* after instancing */
};

/* Imports `name` beneath the directory `root` and writes the blob to `out`, which is checked by
 * opening it before this returns. A failure leaves no part of a blob behind. *warnings is filled in
 * in both cases. */
int import_scene(const char *root, const char *name, const char *out, struct warnings *warnings,
                 struct import_stats *stats, struct fault *fault);
