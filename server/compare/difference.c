#include "server/compare/difference.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The pixels of both images as pairs; every channel of the layer once. */
struct pairs {
    const struct plane *reference[3], *test[3];
    const struct plane *mask; /* of the reference; NULL: all pixels count */
    double above, below;
    int channels;
    int32_t width, height;
};

static bool counts(const struct pairs *p, int32_t x, int32_t y)
{
    if (!p->mask) return true;
    double v = (double)*plane_at(p->mask, x, y);
    return v > p->above && v < p->below;
}

static int64_t count_pixels(const struct pairs *p)
{
    int64_t count = 0;
    for (int32_t y = 0; y < p->height; y++)
        for (int32_t x = 0; x < p->width; x++) count += counts(p, x, y);
    return count;
}

static double mean_of(const struct pairs *pairs, const struct plane *p)
{
    double sum = 0;
    int64_t count = 0;
    for (int32_t y = 0; y < pairs->height; y++) {
        const float *row = plane_row(p, y);
        for (int32_t x = 0; x < pairs->width; x++) {
            if (!isfinite(row[x]) || !counts(pairs, x, y)) continue;
            sum += row[x];
            count++;
        }
    }
    return count > 0 ? sum / (double)count : 0;
}

static int find_pairs(const struct image *reference, const struct image *test, const char *layer,
                      struct pairs *out, struct fault *fault)
{
    if (reference->width_px != test->width_px || reference->height_px != test->height_px)
        return fault_set(fault, ERR_MISMATCH, "", "sizes differ: %d x %d and %d x %d",
                         reference->width_px, reference->height_px, test->width_px,
                         test->height_px);
    if (!image_layer_planes(reference, layer, out->reference))
        return fault_set(fault, ERR_NOT_FOUND, "", "the reference has no layer \"%s\"", layer);
    if (!image_layer_planes(test, layer, out->test))
        return fault_set(fault, ERR_NOT_FOUND, "", "the test image has no layer \"%s\"", layer);
    out->channels = out->reference[0] == out->reference[1] ? 1 : 3;
    out->width = reference->width_px;
    out->height = reference->height_px;
    return 0;
}

static int find_mask(const struct image *reference, const struct difference_where *where,
                     struct pairs *out, struct fault *fault)
{
    const struct plane *planes[3];
    if (!where) return 0;
    if (!image_layer_planes(reference, where->layer, planes))
        return fault_set(fault, ERR_NOT_FOUND, "", "the reference has no layer \"%s\"",
                         where->layer);
    if (planes[0] != planes[1])
        return fault_set(fault, ERR_RANGE, "", "the layer \"%s\" is no single number a pixel",
                         where->layer);
    out->mask = planes[0];
    out->above = where->above;
    out->below = where->below;
    if (count_pixels(out) == 0)
        return fault_set(fault, ERR_RANGE, "",
                         "the reference's layer \"%s\" is nowhere between %g and %g", where->layer,
                         where->above, where->below);
    return 0;
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Sums over one channel; `errors` collects |x - r|. */
static void add_channel(const struct pairs *p, int channel, double floor_squared,
                        struct difference *d, float *errors, size_t *count)
{
    for (int32_t y = 0; y < p->height; y++) {
        const float *r = plane_row(p->reference[channel], y);
        const float *t = plane_row(p->test[channel], y);
        for (int32_t x = 0; x < p->width; x++) {
            if (!counts(p, x, y)) continue;
            double e = (double)t[x] - r[x];
            if (!isfinite(e)) {
                d->finite = false;
                continue;
            }
            double weight = (double)r[x] * r[x] + floor_squared;
            d->rmse += e * e;
            /* A black pixel in a black reference: the error itself is all there is to say. */
            d->relmse += weight > 0 ? e * e / weight : e * e;
            d->bias += e;
            errors[(*count)++] = (float)fabs(e);
        }
    }
}

int image_difference(const struct image *reference, const struct image *test, const char *layer,
                     struct difference *out, struct fault *fault)
{
    return image_difference_where(reference, test, layer, NULL, out, fault);
}

int image_difference_where(const struct image *reference, const struct image *test,
                           const char *layer, const struct difference_where *where,
                           struct difference *out, struct fault *fault)
{
    struct pairs p = {0};
    size_t count = 0;
    int error = find_pairs(reference, test, layer, &p, fault);
    if (!error) error = find_mask(reference, where, &p, fault);
    if (error) return error;
    assert(p.channels > 0 && p.width > 0 && p.height > 0); /* images have pixels */
    *out = (struct difference){.finite = true, .pixels = count_pixels(&p)};
    float *errors = malloc((size_t)p.channels * (size_t)out->pixels * sizeof *errors);
    if (!errors) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    for (int c = 0; c < p.channels; c++) {
        out->mean_reference[c] = mean_of(&p, p.reference[c]);
        out->mean_test[c] = mean_of(&p, p.test[c]);
    }
    for (int c = 0; c < 3; c++) {
        double r = out->mean_reference[c];
        out->ratio[c] = r != 0 ? out->mean_test[c] / r : (double)NAN;
        out->mean += c < p.channels ? r / p.channels : 0;
    }
    for (int c = 0; c < p.channels; c++)
        add_channel(&p, c, 0.01 * out->mean * out->mean, out, errors, &count);
    if (count > 0) {
        out->rmse = sqrt(out->rmse / (double)count);
        out->relmse /= (double)count;
        out->bias /= (double)count;
        qsort(errors, count, sizeof *errors, compare_floats);
        out->p999 = (double)errors[(size_t)(0.999 * (double)(count - 1))];
        out->max = (double)errors[count - 1];
    }
    free(errors);
    return 0;
}
