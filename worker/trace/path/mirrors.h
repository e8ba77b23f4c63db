#pragma once
/* Surfaces seen in flat mirrors through a lens.
 *
 * A flat mirror is a window into the scene's mirror image. Camera rays are followed through it to
 * the surface behind, which is placed at its mirror image: straight ahead, at the whole length of
 * the path, with its normal mirrored back. The mirrored surface can then be matched like any other:
 * light fields light it, and the lens blurs it by its image's distance from the focus. Its light is
 * sampled at the real place.
 *
 * A mirror is a surface that reflects into one direction only (BSDF_MIRROR; glTF metals without
 * roughness) and does not emit, on flat triangles that are no part of a finely curved mesh. Images
 * in curved mirrors lie elsewhere. Each reflection is one of the path's scatterings. */
#include "proto/plan.h"
#include "worker/trace/hit/hit.h"

struct path_context;
struct path_packet;
struct path_vertex;

/* The reflections of sixteen camera rays; the other members are set only if `any` is. */
struct mirrors {
    bool any;
    uint32_t count[LANES];                       /* reflections; 0: seen directly */
    struct lanes3 eye, way;                      /* the camera's rays */
    _Alignas(LANES_ALIGN) float distance[LANES]; /* along them to the mirror image; INFINITY: the
                                                    rays have met nothing behind mirrors */
    struct lanes3 tint;                          /* what mirrors leave of light */
    struct lanes3 normal[PLAN_LENS_MIRRORS];     /* of the mirrors, the first met first */
};

/* Follows the camera rays that have met v->surface through up to c->plan->lens_mirrors mirrors. The
 * rays and the surface become those behind, and v->mirrors records the reflections. With a packet p
 * of paths, whose rays are `rays`, its throughput is multiplied, too; NULL: there are no paths.
 * Overwrites what path_resolve sets. */
void mirrors_follow(const struct path_context *c, struct path_packet *p, struct RTCRayHit16 *rays,
                    struct path_vertex *v);

/* Computes lane i's point and normal as the camera sees them. */
void mirrors_image(const struct path_vertex *v, int i, float point[3], float normal[3]);

/* Returns the surface with the distance and normal that the camera sees, for the planes. */
const struct surface *mirrors_seen(const struct path_vertex *v, struct surface *copy);
