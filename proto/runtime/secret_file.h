#pragma once
/* Small files that other users cannot read: hashes of tokens, keys. */
#include <stddef.h>

#include "proto/error.h"

/* Who but its owner may read a secret of ours. What engines hand to a service belongs to root, and
 * the service reads it by its group; so the group of another owner's file may always. */
enum secret_readers { SECRET_READERS_NONE, SECRET_READERS_GROUP };

/* The whole file, with a NUL behind it, to be freed. Refused (ERR_STATE) when others may read or
 * write it, when its group may write it, or read a file of ours though `readers` says that it may
 * not, or when it belongs neither to us nor to root; a FIFO or a device is not waited for.
 * ERR_NOT_FOUND, ERR_LIMIT, ERR_IO, ERR_MEMORY. *fault names it. */
int secret_file_read(const char *path, enum secret_readers readers, size_t limit_bytes, char **out,
                     size_t *size_bytes, struct fault *fault);

/* Replaces it as a whole, readable by its owner alone, and durable with 0. */
int secret_file_write(const char *path, const char *text, size_t size_bytes, struct fault *fault);
