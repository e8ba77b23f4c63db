#pragma once
/* An environment map ready for tracing: texels for lookups, and an alias table over them by
 * luminance times solid angle for sampling (Vose 1991). Built once, shared read-only.
 *
 * Directions here are the map's own: u = 0.5 + atan2(z, x)/2 pi, v = acos(y)/pi from the top row.
 * Lookups are bilinear, wrapping around in u and clamped in v; the density of a sample is constant
 * over a texel. Nothing here calls the C library's trigonometry: bytes must not depend on the CPU.
 */
#include "proto/environment.h"

struct environment;

/* `blob` is borrowed and must outlive the result. ERR_MEMORY. */
int environment_create(const struct environment_blob *blob, struct environment **out);
void environment_destroy(struct environment **environment);

uint64_t environment_bytes(const struct environment *e); /* held beside the blob */

/* Radiance from a unit direction. */
void environment_lookup(const struct environment *e, const float direction[3], float radiance[3]);

/* A unit direction by three uniform numbers, and its density per solid angle (0 for a black map:
 * no sample). */
void environment_sample(const struct environment *e, float choice, const float u[2],
                        float direction[3], float *pdf);

/* The density with which environment_sample chooses a unit direction. */
float environment_pdf(const struct environment *e, const float direction[3]);
