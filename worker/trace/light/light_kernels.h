#pragma once
/* The inner loops over sixteen pixels' light samples. */
#include "proto/runtime/kernels.h"
#include "worker/trace/light/light.h"
#include "worker/trace/light/shadow_sums.h"
#include "worker/trace/light/strata.h"

struct light_kernels {
    /* Takes one sample of a light in each lane; (u, v) in [0, 1)^2 place it on a rectangle. Only
     * lanes of `lanes` are traced; their rays are fit for Embree. */
    void (*sample_light)(const struct light *light, const float *u, const float *v,
                         const struct surface *receiver, const struct lanes_mask *lanes,
                         struct light_packet *out);

    /* Sets out->skip to what all strata of a rectangle are skipped for. Returns whether they are in
     * all lanes of `lanes`. */
    bool (*light_hidden)(const struct light *light, const struct surface *receiver,
                         const struct lanes_mask *lanes, struct light_packet *out);

    /* Compute the pixels' jitters, and their l strata along each axis: out->l, column and row. */
    void (*lattice_jitters)(const struct pattern_lattice *lattice, const struct block *b,
                            float *jitter0, float *jitter1);
    void (*place_strata)(const float *jitter0, const float *jitter1, uint32_t l,
                         struct strata *out);

    /* Does sample_light for strata first .. first + count - 1, a packet each, but leaves densities
     * alone. Returns whether all lanes of `lanes` are traced in all of them. */
    bool (*sample_strata)(const struct light *light, const struct strata *strata, uint32_t first,
                          uint32_t count, const struct surface *receiver,
                          const struct lanes_mask *lanes, struct light_packet *batch);

    /* Adds strata first .. first + count - 1 of l x l, whose rays have come back. The first starts
     * the sums, the last makes means of them; visibility goes to bits from first & 7 on. */
    void (*add_strata)(const struct light_packet *batch, uint32_t first, uint32_t count, uint32_t l,
                       struct shadow_sums *sums);

    /* Stores a byte of visibility where something was hit, and begins the next one. */
    void (*store_visibility)(const struct block *b, const struct lanes_mask *hit,
                             struct shadow_sums *sums, uint8_t *plane);
    void (*add_slopes)(const struct light_packet *p, struct shadow_sums *sums);
};

/* One for each instruction set (kernels.h). All compute the same bits. */
extern const struct light_kernels light_kernels_sse42, light_kernels_avx2, light_kernels_avx512;
