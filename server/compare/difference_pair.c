#include "server/compare/difference_pair.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define KEPT  0.999 /* of the pixels, in relmse999 */
#define FLOOR 0.01  /* beside the square of the reference */

enum { FIRST, SECOND, TEST, IMAGES };
static const char *const names[IMAGES] = {"first reference", "second reference", "test image"};

struct layer {
    const struct plane *planes[IMAGES][3];
    int channels;
    int32_t width, height;
};

static int check_size(const struct image *a, const struct image *b, struct fault *fault)
{
    if (a->width_px == b->width_px && a->height_px == b->height_px) return 0;
    return fault_set(fault, ERR_MISMATCH, "", "sizes differ: %d x %d and %d x %d", a->width_px,
                     a->height_px, b->width_px, b->height_px);
}

static int check_finite(const struct layer *l, const char *layer, struct fault *fault)
{
    for (int i = 0; i < IMAGES; i++)
        for (int c = 0; c < l->channels; c++)
            for (int32_t y = 0; y < l->height; y++)
                for (int32_t x = 0; x < l->width; x++)
                    if (!isfinite(*plane_at(l->planes[i][c], x, y)))
                        return fault_set(fault, ERR_NOT_FINITE, "",
                                         "the %s is not finite in layer \"%s\" at pixel %d, %d",
                                         names[i], layer, x, y);
    return 0;
}

static int find_layer(const struct image *const images[IMAGES], const char *layer,
                      struct layer *out, struct fault *fault)
{
    for (int i = 0; i < IMAGES; i++) {
        int error = check_size(images[FIRST], images[i], fault);
        if (error) return error;
        if (!image_layer_planes(images[i], layer, out->planes[i]))
            return fault_set(fault, ERR_NOT_FOUND, "", "the %s has no layer \"%s\"", names[i],
                             layer);
    }
    out->channels = out->planes[FIRST][0] == out->planes[FIRST][1] ? 1 : 3;
    out->width = images[FIRST]->width_px;
    out->height = images[FIRST]->height_px;
    return check_finite(out, layer, fault);
}

static double clip(double v)
{
    return fmin(fmax(v, 0), 1);
}

/* Returns the IEC 61966-2-1 encoding of a value in [0, 1]. */
static double encode(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

struct products {
    double shown, clipped, relative;
};

/* Sums over a pixel's channels. */
static struct products products_at(const struct layer *l, int32_t x, int32_t y)
{
    struct products sum = {0};
    for (int k = 0; k < l->channels; k++) {
        double v[IMAGES], c[IMAGES], g[IMAGES];
        for (int i = 0; i < IMAGES; i++) {
            v[i] = (double)*plane_at(l->planes[i][k], x, y);
            c[i] = clip(v[i]);
            g[i] = encode(c[i]);
        }
        double r = (v[FIRST] + v[SECOND]) / 2;
        sum.shown += (g[TEST] - g[FIRST]) * (g[TEST] - g[SECOND]);
        sum.clipped += (c[TEST] - c[FIRST]) * (c[TEST] - c[SECOND]);
        sum.relative += (v[TEST] - v[FIRST]) * (v[TEST] - v[SECOND]) / (r * r + FLOOR);
    }
    return sum;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Returns the mean without the largest. Sorts the numbers. */
static double mean_of_max(double *values, size_t count)
{
    size_t kept = count > 1 ? (size_t)(KEPT * (double)count) : 1;
    double sum = 0;
    qsort(values, count, sizeof *values, compare_doubles);
    for (size_t i = 0; i < kept; i++) sum += values[i];
    return sum / (double)kept;
}

/* Sums over all; `relative` collects the relative ones, pixel by pixel. */
static struct products sum_products(const struct layer *l, double *relative)
{
    struct products all = {0};
    for (int32_t y = 0; y < l->height; y++)
        for (int32_t x = 0; x < l->width; x++) {
            struct products here = products_at(l, x, y);
            all.shown += here.shown;
            all.clipped += here.clipped;
            *relative++ = here.relative;
        }
    return all;
}

int difference_pair(const struct image *first, const struct image *second, const struct image *test,
                    const char *layer, struct difference_pair *out, struct fault *fault)
{
    const struct image *const images[IMAGES] = {first, second, test};
    struct layer l = {0};
    int error = find_layer(images, layer, &l, fault);
    if (error) return error;
    size_t count = (size_t)l.width * (size_t)l.height;
    double *relative = malloc(count * sizeof *relative), values = (double)count * l.channels;
    if (!relative) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    struct products all = sum_products(&l, relative);
    *out = (struct difference_pair){
        .psnr_db = all.shown > 0 ? -10 * log10(all.shown / values) : (double)NAN,
        .rmse01 = all.clipped > 0 ? sqrt(all.clipped / values) : (double)NAN,
        .relmse999 = mean_of_max(relative, count) / l.channels};
    free(relative);
    return 0;
}

static void mean_of_planes(const struct plane *a, const struct plane *b, bool errors,
                           const struct plane *to)
{
    for (int32_t y = 0; y < to->height_px; y++) {
        const float *one = plane_row(a, y), *other = plane_row(b, y);
        float *row = plane_row(to, y);
        for (int32_t x = 0; x < to->width_px; x++) {
            double v = (double)one[x], w = (double)other[x];
            row[x] = (float)((errors ? sqrt(v * v + w * w) : v + w) / 2);
        }
    }
}

int difference_pair_mean(const struct image *first, const struct image *second, struct image **out,
                         struct fault *fault)
{
    const char *shared[IMAGE_CHANNELS];
    uint32_t count = 0;
    *out = NULL;
    int error = check_size(first, second, fault);
    if (error) return error;
    for (uint32_t c = 0; c < first->channel_count; c++)
        if (image_plane(second, first->channels[c].name)) shared[count++] = first->channels[c].name;
    if (count == 0)
        return fault_set(fault, ERR_NOT_FOUND, "", "the references have no channel in common");
    error = image_create_named(shared, count, first->width_px, first->height_px, out);
    if (error) return fault_set(fault, error, "", "the references' mean cannot be made");
    for (uint32_t c = 0; c < count; c++)
        mean_of_planes(image_plane(first, shared[c]), image_plane(second, shared[c]),
                       !strncmp(shared[c], "error.", 6), image_plane(*out, shared[c]));
    return 0;
}
