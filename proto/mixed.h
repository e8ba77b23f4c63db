#pragma once
/* Mixed pixels: those on the edge of a surface, of a lamp or of a texture's pattern. Four samples
 * are too few there. The worker traces many more, of geometry alone, and tells how much of the
 * lighting of each of the 3 x 3 pixels around goes into the mixed one (surface_match.h). That is a
 * sparse list beside a tile's planes, whose length does not depend on the number of samples.
 *
 * An entry is what one of the nine, the lender, contributes, as a mean over the samples: each
 * sample splits among lenders by the weights of sub-samples (docs/reconstruction.md,
 * Anti-aliasing). A pixel that is not listed is the mean of its centre and its sub-samples, or of
 * its paths. */
#include "proto/error.h"
#include "proto/plan.h"

/* Slot 3 * (dy + 1) + dx + 1 is the lender dx columns and dy rows beside the pixel. */
#define MIXED_SLOTS    9u
#define MIXED_SLOT_OWN 4u

/* The values of an entry, f32 in [0, 1]. */
enum mixed_value {
    MIXED_SHARE = 0,  /* share of the samples that take its lighting */
    MIXED_ALBEDO = 1, /* rgb: mean of that times diffuse albedo */
    MIXED_REFLECTANCE =
        4, /* rgb: the same with the reflectance of glossy lobes; not always there */
    MIXED_VALUES_MOST = 7
};

/* The list as it is sent: `count` places, strictly ascending, then value by value `count` numbers.
 * A place is pixel * MIXED_SLOTS + slot; the pixel is an element of the tile's planes. */
struct mixed_list {
    uint32_t values; /* of an entry */
    uint32_t count;  /* > 0 */
    uint32_t *words;
};

/* Samples of a mixed pixel: a multiple of 16, at least as many as a light has strata, or as there
 * are bounce rays; under paths, twice as many as these, which know that much themselves. */
#define MIXED_SAMPLES_LEAST  16u
#define MIXED_SAMPLES_A_PATH 2u
uint32_t mixed_samples(const struct plan *plan);

/* Samples of emission at a lamp's edge: a lamp many times as bright as white has to cover its
 * pixels to that part of a step of grey. */
#define GLOW_SAMPLES_LEAST 64u
uint32_t mixed_glow_samples(const struct plan *plan);

/* Samples where these meet nothing that shines beside a lamp, and where they meet so little that
 * the pixel is not white. */
#define GLOW_SAMPLES_DIM    256u
#define GLOW_SAMPLES_SLIVER 1024u

/* Returns the number of an entry's values under the plan: with or without reflectance. */
uint32_t mixed_values(const struct plan *plan);

/* Creates a list of zeros. ERR_MEMORY. mixed_destroy nulls the pointer, which may be NULL. */
int mixed_create(uint32_t values, uint32_t count, struct mixed_list **out);
void mixed_destroy(struct mixed_list **list);

/* Returns the size of a list, which may be NULL. */
size_t mixed_bytes(const struct mixed_list *list);

/* Returns `count` numbers of a value (plus 1 and 2 for green and blue). */
float *mixed_numbers(const struct mixed_list *list, uint32_t value);

/* Checks that places ascend below `places`, and that values are within 0 and 1. ERR_RANGE or
 * ERR_NOT_FINITE; *fault names the entry. */
int mixed_check(const struct mixed_list *list, uint32_t places, struct fault *fault);
