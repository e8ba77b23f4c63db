#pragma once
/* The inner loops over sixteen lanes, once for each instruction set. All of them compute the same
 * bits: no contraction into fused multiply-adds, no approximate reciprocals. */
#include "worker/trace/light.h"
#include "worker/trace/shadow_sums.h"

struct lane_kernels {
    /* Lanes of *valid that Embree can take stay on; returns how many do not. */
    uint32_t (*sanitise)(const struct RTCRay16 *rays, struct lanes_mask *valid);

    /* Turns a surface whose lanes hold raw vectors into what hit.h promises: facet and normal unit
     * and facing the ray, origins off the surface by offset.h of `magnitude`. */
    void (*finish_surface)(const struct RTCRay16 *rays, const float magnitude[LANES],
                           struct surface *s);

    /* octahedron_pack16 of each lane. */
    void (*pack_normals)(const struct lanes3 *normal, uint32_t packed[LANES]);

    /* One sample a lane of a light; (u, v) in [0, 1)^2 place it on a rectangle. */
    void (*sample_light)(const struct light *light, const float *u, const float *v,
                         const struct surface *receiver, struct light_sample *out);

    /* Aims *rays at the sample. Lanes that `lit` holds and the sample does not skip are *traced. */
    uint32_t (*aim)(const struct light_sample *sample, const struct lanes_mask *lit,
                    struct RTCRay16 *rays, struct lanes_mask *traced);

    /* Adds one stratum whose rays have come back. */
    void (*add_stratum)(const struct light_sample *sample, const struct lanes_mask *traced,
                        const float *tfar, uint32_t bit, struct shadow_sums *sums);
};

extern const struct lane_kernels lane_kernels_sse42, lane_kernels_avx2, lane_kernels_avx512;

/* The kernels of an instruction set that build_isa() names. */
const struct lane_kernels *lane_kernels_for(const char *isa);
