#pragma once
/* The l x l strata of sixteen pixels in one dimension of the pattern. Sample i lies in column i % l
 * and row i / l. Since jitter is uniform, l columns and l rows give all l * l points. */
#include "proto/limits.h"
#include "proto/pattern.h"
#include "worker/trace/hit/block.h"

struct strata {
    uint32_t l;                /* of all pixels; 0: each has its own */
    uint32_t per_pixel[LANES]; /* the l of each, when l is 0 */
    _Alignas(LANES_ALIGN) float column[LIMIT_STRATA_PER_AXIS][LANES]; /* u of sample i: i % l */
    _Alignas(LANES_ALIGN) float row[LIMIT_STRATA_PER_AXIS][LANES];    /* v of sample i: i / l */
};

struct light_kernels;

/* Computes the strata of a block. `lattice` is the dimension's, when it is known; or NULL. */
void strata_init(struct strata *s, const struct light_kernels *kernels, const struct pattern *p,
                 const struct pattern_lattice *lattice, const struct block *b, uint32_t dimension,
                 uint32_t l);

/* Does the same where each pixel has its own l, 0 for none. */
void strata_init_per_pixel(struct strata *s, const struct pattern *p, const struct block *b,
                           uint32_t dimension, const uint32_t l[LANES]);

/* Computes sample i of pixels that each have their own l. Lanes without such a sample get any
 * numbers. */
void strata_at(const struct strata *s, uint32_t i, float u[LANES], float v[LANES]);

static inline const float *strata_u(const struct strata *s, uint32_t i)
{
    return s->column[i % s->l];
}

static inline const float *strata_v(const struct strata *s, uint32_t i)
{
    return s->row[i / s->l];
}
