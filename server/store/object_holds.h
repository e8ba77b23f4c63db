#pragma once
/* What of the stored files must not go now: for objects.h. Digests share a stripe by their first
 * byte, so that a hold costs no memory; files beside a held one wait with it: who removes them
 * comes again (asset_removal.h).
 *
 * A stripe's lock is taken while its files are placed and removed, by threads that may wait for the
 * disk. Holds are counted without it: any thread may release. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "proto/digest.h"

#define OBJECT_STRIPES 256

struct object_holds {
    pthread_mutex_t locks[OBJECT_STRIPES];
    atomic_uint counts[OBJECT_STRIPES];
};

void object_holds_init(struct object_holds *h);
void object_holds_lock(struct object_holds *h, const struct digest *d);
void object_holds_unlock(struct object_holds *h, const struct digest *d);
void object_holds_add(struct object_holds *h, const struct digest *d);
void object_holds_release(struct object_holds *h, const struct digest *d);
bool object_holds_any(struct object_holds *h, const struct digest *d);
