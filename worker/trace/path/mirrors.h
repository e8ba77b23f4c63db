#pragma once
/* What flat mirrors show through a lens.
 *
 * A flat mirror is a window into the scene's mirror image: rays that meet it go on, and what they
 * meet at last is seen where it would lie without the mirror, straight ahead as far away as the
 * rays have come in all, with its normal mirrored back. Seen so it is as good as any other surface
 * for who matches points and normals: light fields light it, lenses blur it as far as it is out of
 * focus. Light is looked for at the real place.
 *
 * Mirrors are what surely sends light into one direction only (BSDF_MIRROR; glTF metals without
 * roughness) and does not shine itself, on triangles that are flat and no part of something finely
 * bent: images in curved mirrors lie elsewhere. Each reflection is one of the path's scatterings.
 */
#include "proto/plan.h"
#include "worker/trace/hit/hit.h"

struct path_context;
struct path_packet;
struct path_vertex;

/* Of sixteen camera rays; beside `any` set only where `any` is. */
struct mirrors {
    bool any;
    uint32_t count[LANES];                       /* reflections; 0: seen directly */
    struct lanes3 eye, way;                      /* the camera's rays */
    _Alignas(LANES_ALIGN) float distance[LANES]; /* along them to the mirror image; INFINITY: the
                                                    rays have met nothing behind mirrors */
    struct lanes3 tint;                          /* what mirrors leave of light */
    struct lanes3 normal[PLAN_LENS_MIRRORS];     /* of the mirrors, the first met first */
};

/* Follows the camera rays that have met v->surface through up to c->plan->lens_mirrors mirrors:
 * rays and surface become those behind, v->mirrors tells how they came there. Of a packet p of
 * paths, whose rays are `rays`, the throughput, too; NULL: there are no paths. Changes what
 * path_resolve sets. */
void mirrors_follow(const struct path_context *c, struct path_packet *p, struct RTCRayHit16 *rays,
                    struct path_vertex *v);

/* Lane i's point and normal as the camera sees them. */
void mirrors_image(const struct path_vertex *v, int i, float point[3], float normal[3]);

/* The surface as the camera sees it: its distance and normal. Planes take it. */
const struct surface *mirrors_seen(const struct path_vertex *v, struct surface *copy);
