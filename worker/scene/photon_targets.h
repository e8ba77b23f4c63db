#pragma once
/* The lenses and mirrors of a scene, as spheres around them, towards which photons are sent. */
#include <stdint.h>

#define PHOTON_TARGETS_MAX 64u

struct photon_target {
    float middle[3], radius; /* > 0, the world's */
    uint32_t instance;
};

struct photon_targets {
    uint32_t count; /* > 0 */
    struct photon_target target[PHOTON_TARGETS_MAX];
};

struct render_scene;

/* Finds the largest ones. *out is NULL where there are none. ERR_MEMORY. */
int photon_targets_find(const struct render_scene *scene, struct photon_targets **out);
