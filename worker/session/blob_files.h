#pragma once
/* Blobs in a folder, named by the SHA-256 of their bytes.
 *
 *   DIR/ab/cdef...       whole blobs: verified, then renamed into place; mtime: last use
 *   DIR/parts/HEX        a partly fetched blob; a later fetch continues it
 *
 * Several workers may share a folder. A reader holds a shared lock on its blob, and the writer of a
 * part an exclusive one. Only unlocked files are evicted or swept. There is no shared state in
 * memory, so any thread may use one struct blob_files. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/digest.h"
#include "proto/error.h"

#define BLOB_FILES_PATH_BYTES 4608
#define BLOB_FILES_PART_AGE_S 86400 /* s that the part of a broken transfer is kept */

struct blob_files {
    char dir[4096];
    uint64_t limit_bytes; /* of all files together */
};

/* Creates the folder and removes stale parts. ERR_LIMIT for a long path, ERR_IO. */
int blob_files_open(struct blob_files *c, const char *dir, uint64_t limit_bytes,
                    struct fault *fault);

/* A blob in use: it is not evicted before blob_files_unpin. */
struct blob_pin {
    int fd; /* -1: none */
};

/* Writes the blob's path and pins the blob. ERR_NOT_FOUND when the folder does not have it. */
int blob_files_pin(const struct blob_files *c, const struct digest *digest, struct blob_pin *pin,
                   char path[BLOB_FILES_PATH_BYTES]);
void blob_files_unpin(struct blob_pin *pin);

/* Returns the size of all files. */
uint64_t blob_files_used_bytes(const struct blob_files *c);

/* A blob that is being fetched. */
struct blob_fetch {
    struct digest digest;
    uint64_t have_bytes;     /* the next offset to ask for */
    uint64_t total_bytes;    /* 0: unknown before the first part */
    int fd;                  /* -1: none */
    _Atomic uint64_t *steps; /* grows while the whole is hashed; borrowed, may be NULL */
    char path[BLOB_FILES_PATH_BYTES];
};

/* Opens the part and continues an earlier transfer if there was one. ERR_IO. */
int blob_fetch_begin(const struct blob_files *c, const struct digest *digest, struct blob_fetch *f,
                     struct fault *fault);

/* Appends a part. The first part evicts the least recently used blobs until the whole blob fits.
 * ERR_MISMATCH for a part that does not follow the last one, ERR_LIMIT for a total above
 * LIMIT_BLOB_BYTES, ERR_FULL for one above the folder's limit, ERR_IO. */
int blob_fetch_part(const struct blob_files *c, struct blob_fetch *f, uint64_t total_bytes,
                    uint64_t offset, const void *data, uint32_t size_bytes, struct fault *fault);
bool blob_fetch_is_whole(const struct blob_fetch *f);

/* Hashes the file and moves it to its place. Blocks; any thread may call it. ERR_CHECKSUM (the part
 * is then deleted), ERR_IO. Ends the fetch in any case. */
int blob_fetch_finish(const struct blob_files *c, struct blob_fetch *f, struct fault *fault);

/* Ends the fetch and keeps the part for a later one. */
void blob_fetch_abort(struct blob_fetch *f);
