#pragma once
/* A file that holds a blob (a scene's, an environment map's), mapped for reading. */
#include <stddef.h>

#include "proto/error.h"

/* Maps the whole file, read-only, on a page boundary; blob_file_unmap gives it back. ERR_IO for
 * what cannot be opened or is no file, ERR_TRUNCATED for an empty one, ERR_LIMIT above
 * LIMIT_BLOB_BYTES. */
int blob_file_map(const char *path, const void **blob, size_t *size_bytes, struct fault *fault);

/* Does nothing with NULL. */
void blob_file_unmap(const void *blob, size_t size_bytes);
