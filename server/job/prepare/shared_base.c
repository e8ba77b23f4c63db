#include "server/job/prepare/shared_base.h"

#include <stdatomic.h>
#include <stdlib.h>

struct shared_base {
    atomic_uint refs;
    struct digest digest;
    struct scene scene;
};

int shared_base_open(const struct objects *objects, const struct digest *digest,
                     struct shared_base **out, struct fault *fault)
{
    char path[OBJECTS_PATH_BYTES];
    struct shared_base *base = calloc(1, sizeof *base);
    if (!base) return fault_set(fault, ERR_MEMORY, "base", "no memory for it");
    objects_path(objects, digest, path);
    int error = scene_map(path, &base->scene, fault);
    if (error) {
        free(base);
        return error;
    }
    atomic_init(&base->refs, 1);
    base->digest = *digest;
    *out = base;
    return 0;
}

struct shared_base *shared_base_ref(struct shared_base *base)
{
    if (base) atomic_fetch_add(&base->refs, 1);
    return base;
}

void shared_base_unref(struct shared_base **base)
{
    struct shared_base *b = *base;
    *base = NULL;
    if (!b || atomic_fetch_sub(&b->refs, 1) > 1) return;
    scene_unmap(&b->scene);
    free(b);
}

const struct scene *shared_base_scene(const struct shared_base *base)
{
    return base ? &base->scene : NULL;
}

const struct digest *shared_base_digest(const struct shared_base *base)
{
    return &base->digest;
}
