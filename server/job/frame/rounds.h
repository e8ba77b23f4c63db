#pragma once
/* Decides, round by round, which tiles get how many more samples until a target error is reached.
 *
 * The plan's schedule is the first round. When the frame is reconstructed, each tile's summed
 * squared error is known, split by what would lower it: more paths, more bounce rays, neither.
 * Squared errors are taken to fall with the number of paths, and with the power 2/3 of that of
 * bounce rays, whose filter gets narrower meanwhile (docs/reconstruction.md, Target rounds), as do
 * those of paths under the residual filter. The cost of the target is least where one more sample
 * gains the same everywhere. With V the squared error of a tile of `area` pixels, n its samples a
 * pixel and r the factor by which they grow,
 *
 *   paths     V / r          falls at V / (area n r^2)        = lambda
 *   bounces   V / r^(2/3)    falls at 2 V / (3 area n r^(5/3)) = lambda
 *
 * Bounce rays bring as many of glossy lobes with them, and V of both is one: counts of their own
 * would save 3 to 12 % of the samples of a floor like varnish, 0 to 4 % where little is glossy.
 *
 * wherever r > 1; what gains less than lambda already gets nothing. Lambda is solved for so that
 * the frame's squared errors add up to the target. (Bringing all tiles down to one error instead
 * costs as many samples as giving all the same.)
 *
 * A round multiplies samples by 4 at most, so that errors that were estimated from few are not
 * trusted too far. Decisions follow from the errors alone, and these from the plan. */
#include <stdbool.h>

#include "proto/plan.h"
#include "server/job/frame/foreseen.h"
#include "server/reconstruct/compose/block_variance.h"

/* The error of one tile, over its pixels. */
struct rounds_error {
    double variance[ERROR_SOURCE_COUNT]; /* mean over R, G, B, summed */
    double luminance;                    /* summed */
};

struct rounds;

/* Creates the rounds of a plan with a target, which is borrowed. ERR_MEMORY, ERR_RANGE. */
int rounds_create(const struct plan *plan, struct rounds **out);
void rounds_destroy(struct rounds **rounds);

/* Decides from the errors of all tiles how many more passes each tile gets. Returns whether any
 * gets one; the pictures of the others are final. `more_passes` has room for all tiles. */
bool rounds_decide(struct rounds *r, const struct rounds_error *errors, uint32_t *more_passes);

/* Returns what pass `number` of a tile traces, of the schedule or of a round. */
struct plan_pass rounds_pass(const struct rounds *r, uint32_t tile, uint32_t number);

/* Notes the error of a part of a tile that has all samples of this round, before it is over. */
void rounds_see(struct rounds *r, uint32_t tile, const struct rounds_error *part, uint32_t pixels);

/* Notes an estimate of a whole tile's, which what is seen of it replaces. */
void rounds_glance(struct rounds *r, uint32_t tile, const struct rounds_error *error);

/* Foresees anew from all that was seen since the last decision. */
void rounds_foresee(struct rounds *r);

/* Returns the samples, over a tile's pixels, that the target is still thought to take of it beyond
 * those of the rounds that have ended. */
double rounds_due(const struct rounds *r, uint32_t tile);

struct rounds_report {
    uint32_t rounds;         /* that have ended */
    uint64_t paths, bounces; /* samples of the rounds that were decided on, over all pixels */
    /* all samples that the target is thought to take */
    double expected[FORESEEN_COUNT];
    double reached;   /* estimated error over mean luminance, after the last round */
    double threshold; /* root of what a sample must gain to be taken, over mean luminance */
    double fixed;     /* the part of `reached` that no sample lowers */
    bool met;         /* reached <= target */
};
struct rounds_report rounds_report(const struct rounds *r);
