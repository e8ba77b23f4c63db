#pragma once
/* Numbers of the network: channels of a pixel side by side, pixels row by row, inside a border of
 * zeros one pixel wide, so that windows of 3 by 3 pixels need no cases. */
#include <stddef.h>
#include <stdint.h>

/* Pixels that may be read behind the last one, whose numbers count for nothing. */
#define TENSOR_SLACK_PX 16

struct tensor {
    int32_t width, height, channels;
    float *values; /* owned */
};

/* Creates a tensor of zeros. ERR_MEMORY. */
int tensor_init(struct tensor *t, int32_t width, int32_t height, int32_t channels);
void tensor_fini(struct tensor *t);

/* Returns the first channel of a pixel; x and y from -1 to width and height. */
static inline float *tensor_at(const struct tensor *t, int32_t x, int32_t y)
{
    const size_t pixel = (size_t)(y + 1) * (size_t)(t->width + 2) + (size_t)(x + 1);
    return t->values + pixel * (size_t)t->channels;
}

/* Takes the largest of each 2 by 2 numbers. Frees `in`, whose sizes are even. */
int tensor_pool(struct tensor *in, struct tensor *out);

/* Puts each pixel of `in` where four are, and the channels of `beside` behind its own. Frees `in`.
 */
int tensor_upsample(struct tensor *in, const struct tensor *beside, struct tensor *out);
