#pragma once
/* Mixed pixels: those on the edge of a surface, of a lamp or of a texture's pattern. Four samples
 * are too few there. The worker traces many more, of geometry alone, and tells how much of the
 * lighting of each of the 3 x 3 pixels around goes into the mixed one (surface_match.h). That is a
 * sparse list beside a tile's planes, whose length does not depend on the number of samples.
 *
 * An entry is what one of the nine, the lender, contributes, as a mean over the samples: each
 * sample splits among lenders by the weights of sub-samples (docs/reconstruction.md,
 * Anti-aliasing). A pixel that is not listed is the mean of its centre and its sub-samples, or of
 * its paths. Under whole paths entries say nothing but that their pixels are at edges. */
#include "proto/error.h"
#include "proto/plan.h"
#include "proto/sparse_list.h"

/* Slot 3 * (dy + 1) + dx + 1 is the lender dx columns and dy rows beside the pixel. */
#define MIXED_SLOTS    9u
#define MIXED_SLOT_OWN 4u

/* The values of an entry, in [0, 1]. Its place is pixel * MIXED_SLOTS + slot. */
enum mixed_value {
    MIXED_SHARE = 0,  /* share of the samples that take its lighting */
    MIXED_ALBEDO = 1, /* rgb: mean of that times diffuse albedo */
    MIXED_REFLECTANCE =
        4, /* rgb: the same with the reflectance of glossy lobes; not always there */
    MIXED_VALUES_MAX = 7
};

/* Returns the number of samples of a mixed pixel, a multiple of 16. There are at least as many as a
 * light has strata, or as there are bounce rays. Under paths there are twice as many as paths,
 * since equally many would know no more of the edge than the paths do. */
#define MIXED_SAMPLES_MIN    16u
#define MIXED_SAMPLES_A_PATH 2u
uint32_t mixed_samples(const struct plan *plan);

/* Returns the number of samples of emission at a lamp's edge. The brighter the lamp, the more an
 * error of its coverage shows. */
#define GLOW_SAMPLES_MIN 64u
uint32_t mixed_glow_samples(const struct plan *plan);

/* Samples of a pixel beside a lamp where these meet nothing that shines, and where they meet so
 * little that the pixel is not white. */
#define GLOW_SAMPLES_DIM    256u
#define GLOW_SAMPLES_SLIVER 1024u

/* Returns the number of an entry's values under the plan: with or without reflectance. */
uint32_t mixed_values(const struct plan *plan);

/* Checks that places ascend below `places`, and that values are within 0 and 1. ERR_RANGE or
 * ERR_NOT_FINITE; *fault names the entry. */
int mixed_check(const struct sparse_list *list, uint32_t places, struct fault *fault);
