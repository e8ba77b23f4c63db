#pragma once
/* An environment map ready for tracing: texels for lookups, and an alias table over them for
 * sampling. Built once, shared read-only.
 *
 * Directions here are the map's own: u = 0.5 + atan2(z, x)/2 pi, v = acos(y)/pi from the top row.
 * Lookups are bilinear, wrapping around in u and clamped in v. The density of a sample is constant
 * over a texel: the mean luminance of the lookups inside it over the integral of luminance over the
 * sphere. It is positive wherever a lookup is, so that no rim of a sun is lost.
 *
 * Nothing here calls the C library's trigonometry: bytes must not depend on the CPU. */
#include "proto/environment.h"

struct environment;

/* `blob` is borrowed and must outlive the result. ERR_MEMORY. */
int environment_create(const struct environment_blob *blob, struct environment **out);
void environment_destroy(struct environment **environment);

uint64_t environment_bytes(const struct environment *e); /* held beside the blob */

/* Luminance of lookups: their mean over the sphere, and what none is above. */
float environment_mean(const struct environment *e);
float environment_most(const struct environment *e);

/* Radiance from a unit direction. */
void environment_lookup(const struct environment *e, const float direction[3], float radiance[3]);

/* A unit direction by three uniform numbers in [0, 1), and its density per solid angle (0 for a
 * black map: no sample). `choice` picks the texel, u the place in it; the last of the 24 digits of
 * u lend the choice more digits than a float has, since maps may have 2^25 texels. */
void environment_sample(const struct environment *e, float choice, const float u[2],
                        float direction[3], float *pdf);

/* The density with which environment_sample chooses a unit direction. */
float environment_pdf(const struct environment *e, const float direction[3]);

/* -- the same in steps. Maps are larger than caches: each step asks memory for what the next one
 * reads, and who takes it for several samples before the next waits for all of them at once -- */

/* Position in texels. */
struct environment_spot {
    float u, v;
};

/* environment_lookup and environment_pdf: where a unit direction is; then what is there. */
struct environment_spot environment_find(const struct environment *e, const float direction[3]);
void environment_read(const struct environment *e, struct environment_spot spot, float radiance[3]);
float environment_density(const struct environment *e, const float direction[3],
                          struct environment_spot spot);

/* environment_sample: asks for the table alone; chooses a texel; places a direction within it. */
void environment_expect(const struct environment *e, float choice, const float u[2]);
uint32_t environment_choose(const struct environment *e, float choice, const float u[2]);
void environment_place(const struct environment *e, uint32_t texel, const float u[2],
                       float direction[3], float *pdf);
