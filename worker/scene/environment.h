#pragma once
/* An environment map ready for tracing: texels for lookups, and an alias table over them for
 * sampling. Built once, shared read-only.
 *
 * Directions here are the map's own: u = 0.5 + atan2(z, x)/2 pi, v = acos(y)/pi from the top row.
 * Lookups are bilinear, wrapping around in u and clamped in v. The density of a sample is constant
 * over a texel: the mean luminance of the lookups inside it, less a part of the map's mean, over
 * the integral of that over its bin. It is positive wherever a lookup is, so that no rim of a sun
 * is lost.
 *
 * Texels are gathered in bins, between which sampling chooses first (sky_guide.h): each row of
 * ENVIRONMENT_BINS_V has ENVIRONMENT_BINS_U, numbered along a curve that keeps near bins together.
 *
 * Nothing here calls the C library's trigonometry: bytes must not depend on the CPU. */
#include <math.h>
#include <stdbool.h>

#include "proto/scene/environment.h"
#include "worker/shade/elementary.h"

struct environment;

#define ENVIRONMENT_BINS_U 32u
#define ENVIRONMENT_BINS_V 16u
#define ENVIRONMENT_BINS   (ENVIRONMENT_BINS_U * ENVIRONMENT_BINS_V)

/* Creates the tables of a map. `blob` is borrowed and must outlive the result. ERR_MEMORY. */
int environment_create(const struct environment_blob *blob, struct environment **out);
void environment_destroy(struct environment **environment);

uint64_t environment_bytes(const struct environment *e); /* held beside the blob */

/* Return the mean luminance of lookups over the sphere, and a bound of all of them. */
float environment_mean(const struct environment *e);
float environment_max(const struct environment *e);

/* Return the texels along u and v. */
void environment_size(const struct environment *e, float *width, float *height);

/* Lookups and samples are done in steps. Maps are larger than caches, so each step prefetches what
 * the next one reads. A caller that takes one step for several directions before the next waits for
 * all of them at once. Steps that read no memory are inline, so that loops over lanes vectorise. */

/* Position in texels. */
struct environment_spot {
    float u, v;
};

/* Finds the place of a unit direction on a map of width x height texels: u in [0, width], v in [0,
 * height], and 0 for NaN. Near a pole the angle comes from its sine, since the cosine loses its
 * digits there. */
static inline struct environment_spot environment_find(const float d[3], float width, float height)
{
    const float around = 0.5f + 0.5f * ELEMENTARY_INV_PI * elementary_atan2(d[2], d[0]);
    const float down = ELEMENTARY_INV_PI * elementary_atan2(sqrtf(d[0] * d[0] + d[2] * d[2]), d[1]);
    return (struct environment_spot){around > 0.0f ? around * width : 0.0f,
                                     down > 0.0f ? down * height : 0.0f};
}

/* Prefetch the texels of a lookup, and read its radiance. */
void environment_ask(const struct environment *e, struct environment_spot spot);
void environment_read(const struct environment *e, struct environment_spot spot, float radiance[3]);

/* Return a direction's bin, and the density per solid angle with which it is sampled once its bin
 * is chosen. */
struct environment_density {
    uint32_t bin;
    float within;
};
struct environment_density environment_density(const struct environment *e,
                                               const float direction[3],
                                               struct environment_spot spot);

/* Returns the share of the map's luminance that comes from a bin. All are 0 for a black map. */
double environment_bin_share(const struct environment *e, uint32_t bin);

/* Finds a bin's texels. It has none where a map has few. */
struct environment_rect {
    uint32_t x, y, width, height;
};
struct environment_rect environment_bin_texels(const struct environment *e, uint32_t bin);

/* Returns the bin in column u and row v, from the top. */
uint32_t environment_bin_at(uint32_t u, uint32_t v);

/* A texel that was chosen. Rows below the equator are the upper ones' mirror image: 1 - cos is
 * exact near both poles. */
struct environment_texel {
    double near, far; /* 1 - cos of its edges, from the nearer pole */
    float column;
    bool below;
    float density; /* per solid angle, within its bin; 0: a black map, there is no direction */
};

/* Sample a bin that sends light by three uniform numbers in [0, 1). `choice` picks the texel and u
 * the place in it. The last digits of u refine the choice, since maps may have 2^25 texels and a
 * float has 24 digits. The steps prefetch the table, choose a texel, and look up where it is. */
void environment_expect(const struct environment *e, uint32_t bin, float choice, const float u[2]);
uint32_t environment_choose(const struct environment *e, uint32_t bin, float choice,
                            const float u[2]);
struct environment_texel environment_texel_of(const struct environment *e, uint32_t texel);

/* Computes a unit direction within a texel. */
static inline void environment_place(struct environment_texel t, float width, const float u[2],
                                     float direction[3])
{
    const double along = t.below ? 1.0 - (double)u[1] : (double)u[1];
    const double from_pole = t.near + along * (t.far - t.near);
    const float sine = sqrtf((float)(from_pole * (2.0 - from_pole)));
    const double around = ((double)t.column + (double)u[0]) / (double)width;
    float around_sine, around_cosine;
    elementary_sincos_turn((float)around, &around_sine, &around_cosine);
    direction[0] = -sine * around_cosine;
    direction[1] = (float)(t.below ? from_pole - 1.0 : 1.0 - from_pole);
    direction[2] = -sine * around_sine;
}
