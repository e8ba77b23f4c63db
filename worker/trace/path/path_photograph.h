#pragma once
/* What paths of virtual objects bring of the photograph (worker/scene/photograph.h).
 *
 * A path that leaves an object and meets a catcher or a holdout which the camera sees, too, brings
 * what the photograph shows there, as the objects change it. Two paths go on from there by the same
 * random numbers: one brings light of the scene with the objects, the other without. Their ratio
 * dims the photograph, and what they add to it is scaled as the photograph is to the scene:
 *
 *     throughput * photograph * min(with, without) / without
 *         + throughput * max(with - without, 0) * 2 photograph / (photograph + without)
 *
 * where the quotients are of sums over some of a pixel's samples: those of one path would be off by
 * its noise, however many there are. Where no object is met both paths bring the same bits, and the
 * photograph keeps its colour, whatever the catcher's albedo and its light are. */
#include "worker/trace/path/path.h"

/* Decides which paths of the packet have met such a point, in v, and notes what they bring. From
 * then on they bring the part `with`; those that bring `without` are added to `real`, at the
 * segment that meets the point. */
void path_photograph_meet(const struct path_context *c, struct path_packet *p,
                          const struct path_vertex *v, struct path_scratch *s,
                          struct path_pool *real);

/* Adds what a path brings to its part. */
static inline void path_part_add(struct path_radiance *h, enum path_part part, uint32_t slot,
                                 const float value[3])
{
    struct path_rgb *to = part == PATH_PART_WITH ? &h->shown.with : &h->shown.without;
    to->r[slot] += value[0];
    to->g[slot] += value[1];
    to->b[slot] += value[2];
}

/* Does so for the lanes in *on whose paths have a part, which leave it. */
void path_part_add_lanes(const struct path_packet *p, struct lanes_mask *on,
                         const struct lanes3 *value, struct path_radiance *h);

/* Adds what all paths bring of the photograph, once they have ended: samples first ..
 * first + count - 1 of sixteen pixels, a batch. Sums are over those of it that are in one half of
 * the pass's parts, since filters compare halves: what quotients of so few are off by stays,
 * however many batches there are. */
void path_photograph_add(const struct path_context *c, const struct plan_split *parts,
                         uint32_t first, uint32_t count, struct path_radiance *h);
