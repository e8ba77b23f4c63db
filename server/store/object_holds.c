#include "server/store/object_holds.h"

#include <assert.h>

void object_holds_init(struct object_holds *h)
{
    for (int i = 0; i < OBJECT_STRIPES; i++) {
        pthread_mutex_init(&h->locks[i], NULL);
        atomic_init(&h->counts[i], 0);
    }
}

void object_holds_lock(struct object_holds *h, const struct digest *d)
{
    pthread_mutex_lock(&h->locks[d->bytes[0]]);
}

void object_holds_unlock(struct object_holds *h, const struct digest *d)
{
    pthread_mutex_unlock(&h->locks[d->bytes[0]]);
}

void object_holds_add(struct object_holds *h, const struct digest *d)
{
    atomic_fetch_add(&h->counts[d->bytes[0]], 1);
}

void object_holds_release(struct object_holds *h, const struct digest *d)
{
    const unsigned before = atomic_fetch_sub(&h->counts[d->bytes[0]], 1);
    assert(before > 0);
}

bool object_holds_any(struct object_holds *h, const struct digest *d)
{
    return atomic_load(&h->counts[d->bytes[0]]) > 0;
}
