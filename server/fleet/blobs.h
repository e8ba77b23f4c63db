#pragma once
/* Scene blobs for workers that cannot map them: parts of a file, read where they are asked for. */
#include <stddef.h>
#include <stdint.h>

#include "proto/digest.h"

/* The blob that a session reads at the moment; one file stays open between its parts. */
struct blob_source {
    int fd; /* -1: none */
    struct digest digest;
    uint64_t total_bytes;
};

void blob_source_init(struct blob_source *b);
void blob_source_fini(struct blob_source *b);

/* Opens `path` as the blob `digest`, closing another one. ERR_NOT_FOUND, ERR_IO. */
int blob_source_open(struct blob_source *b, const struct digest *digest, const char *path);

/* Reads the part at `offset`, `size_bytes` or what is left, at most LIMIT_BLOB_PART_BYTES, into
 * *part, which the caller then owns (free). ERR_RANGE beyond the end, ERR_IO, ERR_MEMORY. */
int blob_source_read(const struct blob_source *b, uint64_t offset, uint32_t size_bytes, void **part,
                     uint32_t *part_bytes);
