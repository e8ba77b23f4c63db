#include "tests/bench/unet/tensor.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

int tensor_init(struct tensor *t, int32_t width, int32_t height, int32_t channels)
{
    const size_t pixels = (size_t)(width + 2) * (size_t)(height + 2) + TENSOR_SLACK_PX;
    *t = (struct tensor){width, height, channels, NULL};
    t->values = calloc(pixels * (size_t)channels, sizeof *t->values);
    return t->values ? 0 : ERR_MEMORY;
}

void tensor_fini(struct tensor *t)
{
    free(t->values);
    t->values = NULL;
}

static float larger(float a, float b)
{
    return a > b ? a : b;
}

int tensor_pool(struct tensor *in, struct tensor *out)
{
    int rc = tensor_init(out, in->width / 2, in->height / 2, in->channels);
    for (int32_t y = 0; y < out->height && !rc; y++)
        for (int32_t x = 0; x < out->width; x++) {
            const float *above = tensor_at(in, 2 * x, 2 * y);
            const float *below = tensor_at(in, 2 * x, 2 * y + 1);
            float *to = tensor_at(out, x, y);
            for (int32_t c = 0, n = in->channels; c < n; c++)
                to[c] = larger(larger(above[c], above[c + n]), larger(below[c], below[c + n]));
        }
    tensor_fini(in);
    return rc;
}

int tensor_upsample(struct tensor *in, const struct tensor *beside, struct tensor *out)
{
    const size_t own = (size_t)in->channels, others = (size_t)beside->channels;
    int rc = tensor_init(out, beside->width, beside->height, in->channels + beside->channels);
    for (int32_t y = 0; y < out->height && !rc; y++)
        for (int32_t x = 0; x < out->width; x++) {
            float *to = tensor_at(out, x, y);
            memcpy(to, tensor_at(in, x / 2, y / 2), own * sizeof *to);
            memcpy(to + own, tensor_at(beside, x, y), others * sizeof *to);
        }
    tensor_fini(in);
    return rc;
}
