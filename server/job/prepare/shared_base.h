#pragma once
/* The base of a moving scene, mapped and checked once for all frames that are planned on it. */
#include "proto/scene/scene.h"
#include "server/store/objects.h"

struct shared_base;

/* Opens a blob as a base, with one reference. ERR_NOT_FOUND, ERR_MEMORY, and as scene_map. */
int shared_base_open(const struct objects *objects, const struct digest *digest,
                     struct shared_base **out, struct fault *fault);

/* Take and release a reference; the last release closes the base. Any thread may call them. NULL is
 * ignored; unref nulls the pointer. */
struct shared_base *shared_base_ref(struct shared_base *base);
void shared_base_unref(struct shared_base **base);

const struct scene *shared_base_scene(const struct shared_base *base);
const struct digest *shared_base_digest(const struct shared_base *base);
