#pragma once
/* Writes a finished scene as a blob file. */
#include "server/import/builder.h"

/* Writes header, table and sections to `path`, which is created or replaced. Every byte of the
 * file is determined by the builder. On failure the file is removed. ERR_IO, ERR_LIMIT. */
int blob_write(const struct builder *b, const char *path, struct fault *fault);
