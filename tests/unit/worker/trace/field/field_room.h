#pragma once
/* A room under a camera that looks at one point of its floor: what the path tracer and light fields
 * bring of it, together and apart. */
#include <stdint.h>

#include "proto/half.h"
#include "tests/unit/worker/scene/environment_fixture.h"
#include "tests/unit/worker/tile_fixture.h"
#include "worker/trace/path/path.h"

#define BIT(plane)   PLANE_BIT(plane)
#define SHINES_RECT  1u
#define SHINES_MESH  2u
#define SHINES_SKY   4u
#define SHINES_MAP   8u
#define SHINES_POINT 16u

enum { SIDE_PX = 16, AREA = SIDE_PX * SIDE_PX };

/* What lies under the camera. */
enum kind {
    LAMBERT,
    DIELECTRIC,
    COATED,
    PHONG,
    ASHIKHMIN,
    METAL,
    BRUSHED,
    BECKMANN,
    WARD,
    KELEMEN,
    BLINN,
    KIND_COUNT
};

/* A floor of the material, all pixels at one point of it; a red wall, a glossy one, a low roof. */
struct plan room(struct scene_fixture *f, enum kind kind, uint32_t shines);

void add_field(struct plan *p, uint32_t l);

/* A picture's pixels, all of one expectation; the sums of its paths and the planes of pass 0. */
struct sums {
    double radiance[3][AREA], direct[3][AREA], indirect[3][AREA];
    struct samples *first;
    struct counters counters;
};

struct sums *trace_sums(struct scene_fixture *f, const struct plan *p);
void sums_free(struct sums **s);

static inline double half_at(const struct samples *s, enum plane_id plane, uint32_t c, int i)
{
    return (double)half_to_float(samples_u16(s, plane, c)[i]);
}

/* The light field's part of the picture. */
static inline double field_at(const struct samples *s, uint32_t c, int i)
{
    return samples_u16(s, PLANE_ALBEDO, c)[i] / 65535.0 * half_at(s, PLANE_INDIRECT_MEAN, c, i);
}

/* Standard errors by the scatter between pixels: stratified pixels are nearer to each other than
 * that says. */
void expect_same(const char *what, const double *a, const double *b, double most_error);
