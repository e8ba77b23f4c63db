#pragma once
/* Which objects and materials cover a pixel, by camera samples that are traced for that alone: at
 * places of the pixel filter, of the lens and of the shutter, through what is blended by chance. */
#include "proto/samples.h"
#include "worker/trace/path/path.h"

#define MATTE_SAMPLES_MAX 256u

/* The instances that a pixel's samples have met, as often as each. */
struct matte_list {
    uint32_t kinds, samples;
    uint32_t instance[MATTE_SAMPLES_MAX]; /* SCENE_NONE: nothing */
    uint32_t count[MATTE_SAMPLES_MAX];
};

/* Scratch of one thread. */
struct matte_scratch {
    struct matte_list of[LANES];
    struct path_pool pool;
};

void matte_scratch_init(struct matte_scratch *s);

/* Fills the planes of PLANES_MATTE that `samples` has, of the block's kept pixels. */
void mattes_trace(const struct path_context *paths, const struct block *b, struct matte_scratch *s,
                  struct samples *samples);
