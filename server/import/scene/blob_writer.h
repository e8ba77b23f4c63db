#pragma once
/* Writes a finished scene, or an environment map, as a blob file. */
#include "proto/scene/environment.h"
#include "server/import/scene/builder.h"

/* Writes header, table and sections to `path`, which is created or replaced. Every byte of the
 * file is determined by the builder. On failure the file is removed. ERR_IO, ERR_LIMIT. */
int blob_write(const struct builder *b, const char *path, struct fault *fault);

/* Writes a map likewise: the header of environment_describe, its texels, and the warnings. ERR_IO.
 */
int blob_write_environment(const struct environment_header *header, const float *texels,
                           const struct warnings *warnings, const char *path, struct fault *fault);
