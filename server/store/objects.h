#pragma once
/* Files by the SHA-256 of their bytes: assets, scene blobs, results. A file is there as a whole or
 * not at all: it is written beside its place, synced, then renamed.
 *
 *   DIR/objects/ab/cdef...   the files         DIR/tmp/   what is being written, swept at start
 *
 * Calls block, and any thread may use one struct objects. A file that finish or adopt has placed is
 * held until objects_release, which comes when the reference to it is on record. objects_remove
 * leaves it meanwhile. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/digest.h"
#include "proto/error.h"

#define OBJECTS_PATH_BYTES 4352
#define OBJECT_STRIPES     256

/* Digests share a stripe by their first byte, so that a hold costs no memory: a file beside a held
 * one waits with it. A stripe's lock is taken while its files are placed and removed, by threads
 * that may wait for the disk. Holds are counted without it. */
struct object_holds {
    pthread_mutex_t locks[OBJECT_STRIPES];
    atomic_uint counts[OBJECT_STRIPES];
};

struct objects {
    char dir[4096];
    bool ephemeral; /* the folder is deleted with this process: no file waits for the disk */
    struct object_holds *holds; /* points to own_holds, which changes where the rest is const */
    struct object_holds own_holds;
};

/* Creates the folders and sweeps tmp. The struct must not move from then on. */
int objects_open(struct objects *o, const char *dir, bool ephemeral);
bool objects_have(const struct objects *o, const struct digest *d, uint64_t *size_bytes);
/* Returns whether it is certain that there is no such file. */
bool objects_lack(const struct objects *o, const struct digest *d);
void objects_path(const struct objects *o, const struct digest *d, char out[OBJECTS_PATH_BYTES]);

/* Hold a file that may come, and release what this, finish or adopt holds. Any thread may call
 * them; they wait for nothing. */
void objects_hold(const struct objects *o, const struct digest *d);
void objects_release(const struct objects *o, const struct digest *d);
bool objects_is_held(const struct objects *o, const struct digest *d);

/* Removes a file that is not held and is_free. is_free is called while no thread can place the
 * file. Returns 0 also when there is no such file; it is durably gone then. ERR_STATE if it is
 * held, ERR_EXISTS if it is not free, ERR_IO, ... */
typedef bool (*objects_is_free)(void *ctx, const struct digest *d);
int objects_remove(const struct objects *o, const struct digest *d, objects_is_free is_free,
                   void *ctx);

/* A file being written. Owned by the caller; finish and abort free it and null the pointer. */
struct object_writer;
int object_writer_begin(const struct objects *o, struct object_writer **out);
int object_writer_append(struct object_writer *w, const void *data, size_t size_bytes);

/* Returns the file's name while it is written, for a library that opens files itself. */
const char *object_writer_path(const struct object_writer *w);

/* Does the first half of finish: syncs. With `expected`, ERR_MISMATCH when the bytes' digest is
 * another. *out is the digest in any case. */
int object_writer_seal(struct object_writer *w, const struct digest *expected, struct digest *out);
/* Does the second half for a file that is sealed as d: renames it, or drops it where it is there
 * already. */
int object_writer_place(struct object_writer **w, const struct digest *d, bool *existed);

/* Syncs and renames. With `expected`, ERR_MISMATCH (and nothing kept) when the bytes' digest is
 * another. *out is the digest in any case. A file that is already there stays and this one is
 * dropped: 0 with *existed = true. With 0 it is held. */
int object_writer_finish(struct object_writer **w, const struct digest *expected,
                         struct digest *out, bool *existed);
void object_writer_abort(struct object_writer **w);

/* Tests whether a file can be kept now: writes one, syncs it and removes it. 0, ERR_NO_SPACE,
 * ERR_IO, ... as the disk has it. */
int objects_probe(const struct objects *o);

/* Takes over a finished file at `path` (on the same file system): hashes, syncs, renames. With 0 it
 * is held. */
int objects_adopt(const struct objects *o, const char *path, struct digest *out);

/* Creates a private folder under tmp/ for the importer. The caller removes it with
 * objects_remove_dir. */
int objects_make_dir(const struct objects *o, char out[OBJECTS_PATH_BYTES]);
void objects_remove_dir(const char *dir);
