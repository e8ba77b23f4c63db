#pragma once
/* Scene blobs in a folder, by the SHA-256 of their bytes.
 *
 *   DIR/ab/cdef...       whole blobs: verified, then renamed into place; mtime: last use
 *   DIR/parts/HEX        a blob on its way; taken up again where it ended
 *
 * Several workers may share a folder. Who uses a blob holds a shared lock on it, who writes a part
 * an exclusive one; only what nobody has locked is evicted or swept. There is no shared state in
 * memory: any thread may use one struct blob_files. */
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

/* Makes the folder, sweeps parts that nobody will take up. ERR_LIMIT for a long path, ERR_IO. */
int blob_files_open(struct blob_files *c, const char *dir, uint64_t limit_bytes,
                    struct fault *fault);

/* A blob in use: it is not evicted before blob_files_unpin. */
struct blob_pin {
    int fd; /* -1: none */
};

/* The blob's path when it is there, ERR_NOT_FOUND otherwise. */
int blob_files_pin(const struct blob_files *c, const struct digest *digest, struct blob_pin *pin,
                   char path[BLOB_FILES_PATH_BYTES]);
void blob_files_unpin(struct blob_pin *pin);

/* Size of all files; for tests and people. */
uint64_t blob_files_used_bytes(const struct blob_files *c);

/* A blob on its way in. */
struct blob_fetch {
    struct digest digest;
    uint64_t have_bytes;     /* the next offset to ask for */
    uint64_t total_bytes;    /* 0: not known before the first part */
    int fd;                  /* -1: none */
    _Atomic uint64_t *steps; /* grows while the whole is hashed; borrowed, may be NULL */
    char path[BLOB_FILES_PATH_BYTES];
};

/* Opens the part, where an earlier transfer ended if there was one. ERR_IO. */
int blob_fetch_begin(const struct blob_files *c, const struct digest *digest, struct blob_fetch *f,
                     struct fault *fault);

/* Adds a part. The first one makes room for the whole: the longest unused blobs go. ERR_MISMATCH
 * for a part that does not fit, ERR_LIMIT for a total above LIMIT_BLOB_BYTES, ERR_FULL for one that
 * the cache cannot hold, ERR_IO. */
int blob_fetch_part(const struct blob_files *c, struct blob_fetch *f, uint64_t total_bytes,
                    uint64_t offset, const void *data, uint32_t size_bytes, struct fault *fault);
bool blob_fetch_is_whole(const struct blob_fetch *f);

/* Hashes the file and puts it in its place. Blocking; any thread. ERR_CHECKSUM (the part is then
 * deleted), ERR_IO. Ends the fetch in any case. */
int blob_fetch_finish(const struct blob_files *c, struct blob_fetch *f, struct fault *fault);

/* Keeps the part for later. */
void blob_fetch_abort(struct blob_fetch *f);
