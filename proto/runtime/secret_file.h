#pragma once
/* Small files that other users cannot read: hashes of tokens, keys. */
#include <stddef.h>

#include "proto/error.h"

/* The whole file, with a NUL behind it, to be freed. Refused (ERR_STATE) when others may read or
 * write it, when its group may write it, or when it belongs neither to us nor to root; a FIFO or a
 * device is not waited for. ERR_NOT_FOUND, ERR_LIMIT, ERR_IO, ERR_MEMORY. *fault names it. */
int secret_file_read(const char *path, size_t limit_bytes, char **out, size_t *size_bytes,
                     struct fault *fault);

/* Replaces it as a whole, readable by its owner alone, and durable with 0. */
int secret_file_write(const char *path, const char *text, size_t size_bytes, struct fault *fault);
