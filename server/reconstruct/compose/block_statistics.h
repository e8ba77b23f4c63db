#pragma once
/* Counts of what the filters did with a block, and the CPU time of each. */
#include "server/reconstruct/glossy/glossy.h"
#include "server/reconstruct/indirect/indirect.h"
#include "server/reconstruct/lens/lens.h"
#include "server/reconstruct/lighting/lens_relight.h"
#include "server/reconstruct/residual/residual.h"
#include "server/reconstruct/shadow/shadow.h"

struct block_statistics {
    uint64_t sub_samples_lone;      /* sub-samples that were shaded on their own */
    uint64_t sub_samples_unmatched; /* others whose surface is shown by no pixel around them */
    uint64_t pixels_mixed;          /* pixels on an edge, with samples of their own */
    uint64_t pixels_background;     /* without a sample that shows a surface */
    /* These include pixels beside the block whose light its sub-samples use. */
    struct shadow_statistics shadow; /* over the lights */
    struct indirect_statistics indirect;
    struct glossy_statistics glossy;
    struct residual_statistics residual;
    struct lens_statistics lens;
    struct lens_relight_statistics lens_relight;
    uint64_t shadow_cpu_us, indirect_cpu_us, glossy_cpu_us,
        lens_cpu_us; /* CPU time of the filters */
    uint64_t residual_cpu_us;
    uint64_t lens_relight_cpu_us; /* CPU time of looking light up for lens samples */
};
