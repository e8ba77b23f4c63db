#pragma once
/* Adds up a pass's paths, a block at a time, and stores the sums in the tile's planes. */
#include "proto/counter.h"
#include "proto/samples.h"
#include "worker/trace/path/path_pool.h"

struct path_sums {
    uint32_t edge_digits; /* of the context */
    uint32_t count;       /* samples so far */
    struct lanes3 radiance, emission, direct, indirect, diffuse_direct, diffuse_indirect, albedo;
    struct lanes3 mean, spread; /* of radiance: running mean, squared deviations from it */
    _Alignas(LANES_ALIGN) float coverage[LANES];
    _Alignas(LANES_ALIGN) float occlusion[LANES];
    uint32_t first;          /* sample of the pass */
    struct plan_split parts; /* of which PATH_HALF_DIFFERENCE2 and halves are made */
    uint32_t lens_strata;    /* l of lens samples, whose halves are a chequer of the lens; else 0 */
    /* Over the samples in first halves of parts; what is scattered, and its diffuse part. */
    bool halves; /* they are wanted */
    struct lanes3 half_scattered, half_direct, half_indirect;
    struct lanes3 normal; /* shading normals of what the camera sees; zeros where it sees nothing */
    _Alignas(LANES_ALIGN) float distance[LANES]; /* to it, along the rays */
    _Alignas(LANES_ALIGN) float weight[LANES];   /* of the samples that features are means of */
    struct lanes3 tint;                          /* of its lobes but the diffuse one */
    _Alignas(LANES_ALIGN) float alpha[LANES];    /* roughness */
    bool splits;                                 /* PATH_HALF_DIFFERENCE2 is wanted */
    struct lanes3 split; /* of this part: first half of radiance less the second */
    _Alignas(LANES_ALIGN) float split_squares[LANES]; /* of the parts before */
};

/* Begins the sums of a pass that the planes want, of 2^edge_digits times as many samples. */
void path_sums_init(struct path_sums *s, const struct plan_pass *pass, uint32_t edge_digits,
                    uint64_t planes);

/* The same of all strata x strata lens samples of a pixel. */
void path_sums_init_lens(struct path_sums *s, uint32_t strata, uint64_t planes);

/* Adds `count` samples of a batch, in their order. Samples that are not finite count as black and
 * are counted in `counters`; `demodulate` as in struct path_context. */
void path_sums_add(struct path_sums *s, struct path_radiance *h, uint32_t count, bool demodulate,
                   struct counters *counters);

/* Takes emission and coverage from `count` samples more, of which these are sums over lanes that
 * are on, or zero. What is scattered, and features, follow the coverage, since all of them come of
 * samples that meet a surface. Lanes whose paths have met none stay as they are. */
void path_sums_see(struct path_sums *s, const struct lanes_mask *on, const struct lanes3 *emission,
                   const float coverage[LANES], uint32_t count);

/* Writes the planes that `samples` has, as if the pass had no more samples than it says; the sums
 * are of no use after that. */
void path_sums_store(struct path_sums *s, const struct block *b, struct samples *samples);
