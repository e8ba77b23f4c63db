#pragma once
/* What the axis-aligned filters of indirect light make of a patch, and a patch of one plane for
 * them. */
#include "server/reconstruct/indirect/indirect.h"
#include "tests/unit/server/reconstruct/indirect/indirect_scene.h"
#include "tests/unit/unit.h"

#define LINES 512

static const uint32_t filters[] = {INDIRECT_FILTER_CONSTANT, INDIRECT_FILTER_LINEAR,
                                   INDIRECT_FILTER_BLEND};

#define FILTERS (sizeof filters / sizeof *filters)

struct picture {
    float *channel[3], *width; /* of the patch's size */
    struct indirect_statistics statistics;
};

void picture_init(struct picture *p, const struct patch *patch);
void picture_fini(struct picture *p);

/* Filters the patch's indirect light over `inner`, block by block. */
void filter_blocks(const struct plan *plan, const struct patch *patch, struct rect inner,
                   int32_t side, struct picture *out);

size_t index_of(const struct patch *patch, int32_t x, int32_t y);

/* A plane across the view, `distance` away, whose reflectors are `reflector` away. */
struct patch *plane_patch(struct plan *plan, int32_t width, int32_t height, float distance,
                          float bounce_distance_min);
