#include "server/image/plate.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

struct plate {
    _Atomic uint32_t references;
    struct image *image; /* owned */
};

/* Which texels a pixel of one axis averages: `count` from `first` on, with their weights. */
struct plate_span {
    int32_t first, count;
    float *weights; /* of the axis */
};

struct plate_axis {
    struct plate_span *spans; /* owned; one a pixel */
    float *weights;           /* owned */
};

static void axis_fini(struct plate_axis *axis)
{
    free(axis->spans);
    free(axis->weights);
}

/* The part of texel `i` that lies between two places. */
static double overlap(int32_t i, double from, double to)
{
    const double low = fmax(from, i), high = fmin(to, i + 1.0);
    return high > low ? high - low : 0;
}

/* Weighs the texels of pixel p, which shows `scale` texels in the middle of which `at` lies. Less
 * than one texel is widened to one, which interpolates. */
static void weigh(double at, double scale, int32_t texels, struct plate_span *span)
{
    const double half = fmax(scale, 1.0) / 2;
    const double from = fmin(fmax(at - half, 0), texels - 1.0), to = fmin(at + half, texels);
    double sum = 0;
    span->first = (int32_t)from;
    span->count = 0;
    for (int32_t i = span->first; i < texels && i < to; i++) {
        const double weight = overlap(i, from, to);
        span->weights[span->count++] = (float)weight;
        sum += weight;
    }
    if (!(sum > 0)) { /* beyond the first or the last texel's middle */
        span->weights[0] = 1;
        span->count = 1;
        return;
    }
    for (int32_t k = 0; k < span->count; k++)
        span->weights[k] = (float)((double)span->weights[k] / sum);
}

/* `scale`: texels a pixel. The middles of both lie on each other. */
static int axis_init(int32_t texels, int32_t pixels, double scale, struct plate_axis *out)
{
    const size_t most = (size_t)ceil(fmax(scale, 1.0)) + 2;
    out->spans = calloc((size_t)pixels, sizeof *out->spans);
    out->weights = calloc((size_t)pixels * most, sizeof *out->weights);
    if (!out->spans || !out->weights) return ERR_MEMORY;
    for (int32_t p = 0; p < pixels; p++) {
        out->spans[p].weights = out->weights + (size_t)p * most;
        weigh(texels / 2.0 + (p + 0.5 - pixels / 2.0) * scale, scale, texels, &out->spans[p]);
    }
    return 0;
}

static void put_pixel(const float *texels, int32_t across, const struct plate_span *x,
                      const struct plate_span *y, float out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (int32_t j = 0; j < y->count; j++) {
        const float *row =
            texels + 3 * ((size_t)(y->first + j) * (size_t)across + (size_t)x->first);
        for (int32_t i = 0; i < x->count; i++)
            for (int c = 0; c < 3; c++) out[c] += y->weights[j] * x->weights[i] * row[3 * i + c];
    }
}

/* Weights of pixels that show one texel each are 1, so that a plate of the picture's size keeps
 * its bits. */
static void resample(const float *texels, int32_t across, const struct plate_axis *x,
                     const struct plate_axis *y, struct image *image)
{
    for (int32_t row = 0; row < image->height_px; row++)
        for (int32_t column = 0; column < image->width_px; column++) {
            float rgb[3];
            put_pixel(texels, across, &x->spans[column], &y->spans[row], rgb);
            for (int c = 0; c < 3; c++) *plane_at(&image->channels[c].plane, column, row) = rgb[c];
        }
}

int plate_create(const float *texels, int32_t texels_across, int32_t texels_down, int32_t width_px,
                 int32_t height_px, enum plate_scaling scaling, struct plate **out)
{
    static const char *const names[] = {"R", "G", "B"};
    struct plate_axis x = {0}, y = {0};
    double across = (double)texels_across / width_px, down = (double)texels_down / height_px;
    if (scaling == PLATE_COVER) across = down = fmin(across, down);
    struct plate *plate = calloc(1, sizeof *plate);
    int error =
        plate ? image_create_named(names, 3, width_px, height_px, &plate->image) : ERR_MEMORY;
    if (!error) error = axis_init(texels_across, width_px, across, &x);
    if (!error) error = axis_init(texels_down, height_px, down, &y);
    if (!error) {
        plate->references = 1;
        resample(texels, texels_across, &x, &y, plate->image);
        *out = plate;
    } else if (plate) {
        image_destroy(&plate->image);
        free(plate);
    }
    axis_fini(&x);
    axis_fini(&y);
    return error;
}

int plate_shrink(const struct plate *plate, int32_t width_px, int32_t height_px, struct plate **out)
{
    struct image *image = plate->image;
    const int32_t width = image->width_px, height = image->height_px;
    float *texels = malloc((size_t)width * (size_t)height * 3 * sizeof *texels);
    if (!texels) return ERR_MEMORY;
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            for (int c = 0; c < 3; c++)
                texels[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] =
                    *plane_at(&image->channels[c].plane, x, y);
    const int error = plate_create(texels, width, height, width_px, height_px, PLATE_STRETCH, out);
    free(texels);
    return error;
}

struct plate *plate_hold(struct plate *plate)
{
    if (plate) atomic_fetch_add(&plate->references, 1);
    return plate;
}

void plate_drop(struct plate **out)
{
    struct plate *plate = *out;
    *out = NULL;
    if (!plate || atomic_fetch_sub(&plate->references, 1) > 1) return;
    image_destroy(&plate->image);
    free(plate);
}

const struct image *plate_image(const struct plate *plate)
{
    return plate->image;
}
