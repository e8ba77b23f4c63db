#include "tests/bench/unet/denoise.h"

#include <math.h>

#include "tests/bench/unet/tone.h"

/* What is not a number becomes `low`. */
static float clamped(float v, float low, float high)
{
    return v > low ? v < high ? v : high : low;
}

static void fill_pixel(const struct denoise_input *p, float exposure, int32_t x, int32_t y,
                       float to[NETWORK_INPUTS])
{
    for (int i = 0; i < 3; i++) {
        const float normal = *plane_at(p->normal[i], x, y);
        to[i] = tone_forward(clamped(*plane_at(p->colour[i], x, y) * exposure, 0.0f, INFINITY));
        to[3 + i] = clamped(*plane_at(p->albedo[i], x, y), 0.0f, 1.0f);
        to[6 + i] = clamped(isnan(normal) ? 0.0f : normal, -1.0f, 1.0f) * 0.5f + 0.5f;
    }
}

static int32_t padded(int32_t size)
{
    return (size + NETWORK_MULTIPLE - 1) / NETWORK_MULTIPLE * NETWORK_MULTIPLE;
}

static int fill(const struct denoise_input *p, float exposure, struct tensor *in)
{
    const int32_t width = p->colour[0]->width_px, height = p->colour[0]->height_px;
    int rc = tensor_init(in, padded(width), padded(height), NETWORK_INPUTS);
    for (int32_t y = 0; y < height && !rc; y++)
        for (int32_t x = 0; x < width; x++) fill_pixel(p, exposure, x, y, tensor_at(in, x, y));
    return rc;
}

static void show(const struct tensor *from, float exposure, const struct plane *const out[3])
{
    for (int i = 0; i < 3; i++)
        for (int32_t y = 0; y < out[i]->height_px; y++)
            for (int32_t x = 0; x < out[i]->width_px; x++)
                *plane_at(out[i], x, y) = tone_inverse(tensor_at(from, x, y)[i]) / exposure;
}

int denoise_run(const struct network *network, const struct denoise_input *in,
                const struct plane *const out[3], float *exposure, struct fault *fault)
{
    struct tensor given, made = {0};
    *exposure = tone_exposure(in->colour);
    int rc = fill(in, *exposure, &given);
    if (rc) fault_set(fault, rc, "", "no memory for a picture");
    if (!rc) rc = network_run(network, &given, &made, fault);
    if (!rc) show(&made, *exposure, out);
    tensor_fini(&given);
    tensor_fini(&made);
    return rc;
}
