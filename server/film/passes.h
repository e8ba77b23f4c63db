#pragma once
/* Adds up the passes of a tile. */
#include "proto/samples.h"

/* How many samples every pixel has. */
struct pass_counts {
    uint32_t paths, bounces;
    const uint8_t *strata_map; /* strata per axis of each pixel's second set, of bounce rays or
                             paths through the lens; NULL: none. Borrowed */
    const uint8_t *lobes;      /* the same for rays of glossy lobes */
    /* How many of the paths are in parts that PATH_HALF_DIFFERENCE2 is made of, and the sum of the
     * parts' lengths over these paths. */
    uint64_t split, split_lengths;
};

static inline struct pass_counts pass_counts_of(const struct plan_pass *pass)
{
    const struct plan_split parts = plan_pass_split(pass);
    const uint64_t split = (uint64_t)parts.length * parts.count;
    return (struct pass_counts){.paths = pass->count,
                                .bounces = pass->strata_map ? 0 : pass->strata * pass->strata,
                                .strata_map = pass->strata_map,
                                .lobes = pass->lobes,
                                .split = split,
                                .split_lengths = split * parts.length};
}

/* Adds counts. A tile has one second set at most. */
static inline void pass_counts_add(struct pass_counts *sum, const struct pass_counts *more)
{
    sum->paths += more->paths;
    sum->bounces += more->bounces;
    sum->strata_map = more->strata_map ? more->strata_map : sum->strata_map;
    sum->lobes = more->lobes ? more->lobes : sum->lobes;
    sum->split += more->split;
    sum->split_lengths += more->split_lengths;
}

/* Adds `more` to `sum`: sums of paths, and means over bounce rays, weighted by their number. Both
 * have those planes of the plan that they have samples for; other planes of `sum` stay. If `more`
 * has bounce rays, so has `sum`, and those of `more` fall into halves of one size. There are as
 * many rays of glossy lobes. A second set has only mean radiance, ambient visibility and the means
 * of glossy lobes.
 *
 * PATH_M2, the squared deviations from the mean, is merged by the formula of Chan, Golub and
 * LeVeque (Updating formulae and a pairwise algorithm for computing sample variances, 1979,
 * equation 2.1): S = S_a + S_b + d^2 n_a n_b / (n_a + n_b), with d the difference of the means of
 * PATH_RADIANCE. */
void passes_add(struct samples *sum, struct pass_counts sum_counts, const struct samples *more,
                struct pass_counts more_counts);
