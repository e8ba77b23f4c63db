#pragma once
/* Lone sub-samples: those whose surface no pixel of the 3 x 3 around them shows (surface_match.h).
 * They lie on wires, fences and leaves that are narrower than a pixel. Since no pixel has lighting
 * for them, the worker shades each with as many light samples as the plan gives a pixel, and sends
 * a sparse list of them beside a tile's planes. */
#include "proto/error.h"
#include "proto/plan.h"
#include "proto/sparse_list.h"

/* The values of each (RGB, f32): the radiance that a white Lambert surface in its place would
 * reflect and the radiance that its glossy lobe sees, as in struct lighting.
 * A place is pixel * sub_samples + sub-sample. */
enum lone_part {
    LONE_DIRECT = 0,        /* sum over lights of E_k color_k / pi */
    LONE_INDIRECT = 1,      /* mean over its bounce rays */
    LONE_INDIRECT_HALF = 2, /* mean over half of these; where errors are wanted */
    LONE_GLOSSY = 3,        /* mean over its lobe's rays of weight * radiance over reflectance */
    LONE_GLOSSY_HALF = 4,   /* the same of half of these */
    LONE_PART_COUNT = 5
};

/* Radiance is clamped to this, so that sums over sub-samples stay finite. */
#define LONE_RADIANCE_MAX 1e30f

/* Returns the parts of a plan's lists: those that it samples for pixels. 0: it has no light fields.
 */
uint32_t lone_parts(const struct plan *plan);

/* Returns the number of 32-bit words of an entry. */
uint32_t lone_words(uint32_t parts);

/* Creates a list of zeros. ERR_MEMORY. */
int lone_create(uint32_t parts, uint32_t count, struct sparse_list **out);

/* Returns a channel of a part, `count` numbers; NULL if the list has no such part. */
float *lone_values(const struct sparse_list *list, enum lone_part part, uint32_t channel);

/* Checks that places ascend below `places`, and that radiance is finite and within 0 and
 * LONE_RADIANCE_MAX. ERR_RANGE or ERR_NOT_FINITE; *fault names the entry. */
int lone_check(const struct sparse_list *list, uint32_t places, struct fault *fault);
