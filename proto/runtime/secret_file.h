#pragma once
/* Small files that other users cannot read: hashes of tokens, keys. */
#include <stddef.h>

#include "proto/error.h"

/* Which users beside the owner may read a secret file of ours. What container engines hand to a
 * service belongs to root, and the service reads it by its group; so the group may always read
 * another owner's file. */
enum secret_readers { SECRET_READERS_NONE, SECRET_READERS_GROUP };

/* Reads the whole file, with a NUL behind it, which the caller frees. ERR_STATE when others may
 * read or write it, when its group may write it, or may read a file of ours against `readers`, or
 * when it belongs neither to us nor to root. A FIFO or a device is not waited for. ERR_NOT_FOUND,
 * ERR_LIMIT, ERR_IO, ERR_MEMORY. *fault names it. */
int secret_file_read(const char *path, enum secret_readers readers, size_t limit_bytes, char **out,
                     size_t *size_bytes, struct fault *fault);

/* Replaces the file as a whole, readable by its owner alone. It is durable when 0 is returned. */
int secret_file_write(const char *path, const char *text, size_t size_bytes, struct fault *fault);
