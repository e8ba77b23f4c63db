#pragma once
/* Filters hits on transparent surfaces in Embree. It is set only on geometries whose material can
 * be transparent.
 *
 * A masked surface is there where its alpha reaches the cutoff. A blended one of opacity a is there
 * for the share a of rays: a ray with a key (RTCRay.id other than 0) meets it iff a number hashed
 * from the key and the surface (instance, geometry, triangle) is below a. Every surface draws its
 * own number, so light that passes several is weakened by the product of what each lets through,
 * in whatever order Embree finds them; the same ray meets the same surfaces each time, also when
 * Embree asks twice about a hit. Closest hits and shadow rays are unbiased alike, as the estimate
 * of one ray is linear in each surface's presence.
 *
 * The limits: rays of equal keys see the same numbers, so each ray of a path needs a key of its
 * own; and there are only 2^32 keys, so a mean over more rays gets no better. Rays without a key
 * meet blended surfaces as masks of cutoff one half. */
#include <stdint.h>

#include "worker/scene/render_scene.h"

struct RTCFilterFunctionNArguments;

/* Drops hits, as rtcSetGeometryIntersectFilterFunction and its occluded twin want. The geometry's
 * user data is its struct mesh_view. */
void alpha_filter(const struct RTCFilterFunctionNArguments *args);

/* A hit as the filter meets it. */
struct alpha_hit {
    uint32_t ray; /* key; 0: none */
    uint32_t instance, geometry, triangle;
    float u, v; /* barycentric */
};

/* Returns whether the hit's surface is there for its ray. */
bool alpha_covers(const struct mesh_view *mesh, const struct alpha_hit *hit);
