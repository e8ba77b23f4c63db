#pragma once
/* Paths made of formulas: what a sample of a pixel sees is a pure function of both, so that sums
 * can be checked however the image and its samples are cut. */
#include <stdint.h>

#include "tests/unit/server/reconstruct/synthetic.h"

/* Only paths, all their planes, on top of the synthetic scene's depth, normals and ids. */
void synthetic_paths_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                          uint32_t spp);

/* Paths, and beside them bounce rays of pixel centres with open shares. */
void synthetic_beside_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                           uint32_t spp);

/* In [0, 1), by pixel, sample and a number for what is asked. */
float synthetic_random(int32_t x, int32_t y, uint32_t sample, uint32_t what);

/* Component c of a plane, of one sample; the spread is none of these. */
float synthetic_path(enum plane_id plane, int32_t x, int32_t y, uint32_t sample, uint32_t c);

/* Squared deviations of samples first .. first + count - 1 from their mean. */
double synthetic_spread(int32_t x, int32_t y, uint32_t first, uint32_t count, uint32_t c);

/* As a worker adds up: in float, sample by sample. */
float synthetic_path_sum(enum plane_id plane, int32_t x, int32_t y, uint32_t first, uint32_t count,
                         uint32_t c);

/* What a pixel holds after `passes` passes: their sums, in their order. */
float synthetic_passes_sum(const struct plan *plan, enum plane_id plane, int32_t x, int32_t y,
                           uint32_t passes, uint32_t c);

/* Any pass, also of a plan with halves. Owned by the caller; NULL on failed allocation. */
struct samples *synthetic_pass_of(const struct plan *plan, uint32_t tile,
                                  const struct plan_pass *pass);

/* Paths beside halves of bounce rays, until their error is known well enough. */
void synthetic_target_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                           float target);

/* Bounce rays in two sets, beside paths if there are any. */
void synthetic_rate_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                         uint32_t spp);

/* Owned by the caller; NULL on failed allocation. */
struct samples *synthetic_pass(const struct plan *plan, uint32_t tile, uint32_t pass);
