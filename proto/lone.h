#pragma once
/* Lone sub-samples: those whose surface no pixel of the 3 x 3 around them shows (surface_match.h),
 * as on wires, fences and leaves that are narrower than a pixel. No pixel has lighting for them, so
 * the worker shades each on its own, by as many light samples as the plan gives a pixel, and a
 * sparse list of them travels beside a tile's planes. */
#include "proto/error.h"
#include "proto/plan.h"

/* What is known of each: rgb, f32. Radiance that a white Lambert surface in its place would send
 * out, and radiance that its glossy lobe sees, as struct lighting has them of pixels. */
enum lone_part {
    LONE_DIRECT = 0,        /* sum over lights of E_k color_k / pi */
    LONE_INDIRECT = 1,      /* mean over its bounce rays */
    LONE_INDIRECT_HALF = 2, /* mean over half of these; where errors are wanted */
    LONE_GLOSSY = 3,        /* mean over its lobe's rays of weight * radiance over reflectance */
    LONE_GLOSSY_HALF = 4,   /* the same of half of these */
    LONE_PART_COUNT = 5
};

/* Light beyond this counts as this: sums over sub-samples stay finite. */
#define LONE_RADIANCE_MAX 1e30f

/* As it travels: `count` places, strictly ascending, then of each part that there is its three
 * channels, `count` numbers each. A place is pixel * sub_samples + sub-sample, the pixel an element
 * of the tile's planes. */
struct lone_list {
    uint32_t parts; /* bits of enum lone_part */
    uint32_t count; /* > 0 */
    uint32_t *words;
};

/* The parts that the plan's lists have: what it samples of pixels. 0: it has no light fields. */
uint32_t lone_parts(const struct plan *plan);

/* 32-bit words of an entry. */
uint32_t lone_words(uint32_t parts);

/* Zeros. ERR_MEMORY; destroy nulls the pointer, which may be NULL. */
int lone_create(uint32_t parts, uint32_t count, struct lone_list **out);
void lone_destroy(struct lone_list **list);

/* Of a list that may be NULL. */
size_t lone_bytes(const struct lone_list *list);

/* A channel of a part, `count` numbers; NULL where the list has no such part. */
float *lone_values(const struct lone_list *list, enum lone_part part, uint32_t channel);

/* 0 when places ascend and are below `places`, and light is finite, not negative and at most
 * LONE_RADIANCE_MAX; else ERR_RANGE or ERR_NOT_FINITE, and *fault names the entry. */
int lone_check(const struct lone_list *list, uint32_t places, struct fault *fault);
