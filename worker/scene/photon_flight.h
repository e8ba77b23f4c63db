#pragma once
/* Follows a photon over lenses and mirrors to the surface behind them. */
#include <stdbool.h>
#include <stdint.h>

#include "worker/scene/material/material.h"
#include "worker/scene/photons.h"

struct render_scene;

struct photon_flight {
    float at[3], way[3]; /* unit, the world's */
    float power;
    float near;  /* surfaces nearer than this are those it comes from */
    uint32_t to; /* the instance that must bend it first */
};

/* Returns whether surfaces of a material send a photon on in one direction. */
bool photon_flight_is_bent_by(const struct material *m);

/* Follows a photon until it meets a surface that does not bend it; at lenses chance decides, as
 * much as they reflect, and what colours leave of it is its power. Sets *out and returns true if
 * f->to has bent it first and it has then met what light falls on. `clearance`: how far from a lens
 * it goes on. */
bool photon_flight_follow(const struct render_scene *scene, struct photon_flight *f,
                          float clearance, uint32_t *random, struct photon *out);
