#pragma once
/* A map of photons: where light arrived that lenses and mirrors had bent, and from which point of
 * them it came (Jensen 1995, "Importance driven path tracing using the photon map"). Paths that
 * leave a place near such photons look the same way.
 *
 * A balanced tree over the places has leaves of a few photons each. Places are the world's. */
#include <stdbool.h>
#include <stdint.h>

/* The largest number of photons of a leaf. A map has as many and more. */
#define PHOTONS_IN_LEAF 16u

struct photon {
    float place[3]; /* where it arrived */
    float from[3];  /* the last point before */
    float power;    /* luminance times area times solid angle */
    float reach;    /* radius of the disc around `from` that others near `place` leave to it */
};

/* Photons that arrived near each other. */
struct photon_leaf {
    uint32_t first, count; /* 8 and more */
    float low[3], high[3]; /* around their places */
    float middle[3];       /* of the points that they come from */
    float flux;            /* their power over the area that they fell on */
    float turn[3][3]; /* how far `from` moves with the place, as far as that is the same for all */
    float share; /* of paths that are to be sent to where they come from; whoever makes the map sets
                    it */
};

struct photons {
    struct photon *photons; /* in the leaves' order */
    struct photon_leaf *leaves;
    struct photon_split *splits; /* children of split i: 2 i + 1 and 2 i + 2 */
    uint32_t count, leaf_count;
};

/* Builds the map of `count` photons at finite places, which it takes over, also when it fails.
 * Returns NULL without memory, and for fewer than PHOTONS_IN_LEAF. */
struct photons *photons_create(struct photon *photons, uint32_t count);
void photons_destroy(struct photons **photons);

/* Returns the leaf of a place, if its photons come from above the surface there; NULL where none of
 * them is near. */
const struct photon_leaf *photons_find(const struct photons *p, const float place[3],
                                       const float normal[3]);
