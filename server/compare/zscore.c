#include "server/compare/zscore.h"

#include <math.h>
#include <stdlib.h>

struct planes {
    const struct plane *reference[3], *test[3];
    const struct plane *test_error[3], *reference_error[3]; /* the latter NULL if unknown */
};

static int find_planes(const struct image *reference, const struct image *test, struct planes *p,
                       struct fault *fault)
{
    if (reference->width_px != test->width_px || reference->height_px != test->height_px) {
        fault_set(fault, ERR_MISMATCH, "", "sizes differ: %d x %d and %d x %d", reference->width_px,
                  reference->height_px, test->width_px, test->height_px);
        return ERR_MISMATCH;
    }
    const char *missing = NULL;
    if (!image_layer_planes(reference, "beauty", p->reference))
        missing = "the reference has no layer \"beauty\"";
    else if (!image_layer_planes(test, "beauty", p->test))
        missing = "the test image has no layer \"beauty\"";
    else if (!image_layer_planes(test, "error", p->test_error))
        missing = "the test image has no layer \"error\"";
    if (missing) {
        fault_set(fault, ERR_NOT_FOUND, "", "%s", missing);
        return ERR_NOT_FOUND;
    }
    if (!image_layer_planes(reference, "error", p->reference_error)) p->reference_error[0] = NULL;
    return 0;
}

/* z, or NAN where there is none. */
static double score_at(const struct planes *p, int c, int32_t x, int32_t y)
{
    double se = (double)*plane_at(p->test_error[c], x, y), other = 0;
    if (p->reference_error[0]) other = (double)*plane_at(p->reference_error[c], x, y);
    double variance = se * se + other * other;
    double difference = (double)*plane_at(p->test[c], x, y) - *plane_at(p->reference[c], x, y);
    if (!(variance > 0) || !isfinite(variance) || !isfinite(difference)) return (double)NAN;
    return difference / sqrt(variance);
}

static void add_score(struct zscore *s, double z, int c, int32_t x, int32_t y)
{
    double size = fabs(z);
    s->count++;
    s->mean += z;
    s->rms += z * z;
    for (int k = 0; k < 3; k++) s->beyond[k] += size > 2 + k;
    if (s->count > 1 && size <= fabs(s->worst)) return;
    s->worst = z;
    s->worst_x = x, s->worst_y = y, s->worst_channel = c;
}

/* sizes: |z| of all that count so far. */
static void add_row(const struct planes *p, int c, int32_t y, float *sizes, struct zscore *out)
{
    for (int32_t x = 0; x < p->test[c]->width_px; x++) {
        const double z = score_at(p, c, x, y);
        if (isnan(z)) {
            out->without++;
            continue;
        }
        sizes[out->count] = (float)fabs(z);
        add_score(out, z, c, x, y);
    }
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Adds standard errors up to those of means over the picture. Errors that are not finite count as
 * 0. */
static void add_errors(const struct planes *p, double floor_squared, struct zscore *s)
{
    const struct plane *first = p->test_error[0];
    double n = (double)first->width_px * first->height_px;
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int32_t y = 0; y < first->height_px; y++) {
            const float *error = plane_row(p->test_error[c], y);
            const float *reference = plane_row(p->reference[c], y);
            for (int32_t x = 0; x < first->width_px; x++) {
                double square = (double)error[x] * error[x];
                double weight = (double)reference[x] * reference[x] + floor_squared;
                if (!isfinite(square) || !isfinite(weight)) continue;
                sum += square;
                s->relmse += (weight > 0 ? square / weight : square) / (3 * n);
            }
        }
        s->mean_error[c] = sqrt(sum) / n;
    }
}

static void finish(struct zscore *s, float *sizes)
{
    if (s->count == 0) return;
    double n = (double)s->count;
    s->mean /= n;
    s->rms = sqrt(s->rms / n);
    for (int k = 0; k < 3; k++) s->beyond[k] /= n;
    qsort(sizes, s->count, sizeof *sizes, compare_floats);
    s->median = (double)sizes[s->count / 2];
}

int image_zscore(const struct image *reference, const struct image *test, double mean,
                 struct zscore *out, struct fault *fault)
{
    struct planes p = {0};
    int error = find_planes(reference, test, &p, fault);
    if (error) return error;
    *out = (struct zscore){0};
    float *sizes = malloc(3 * (size_t)test->width_px * (size_t)test->height_px * sizeof *sizes);
    if (!sizes) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    for (int c = 0; c < 3; c++)
        for (int32_t y = 0; y < test->height_px; y++) add_row(&p, c, y, sizes, out);
    finish(out, sizes);
    add_errors(&p, 0.01 * mean * mean, out);
    free(sizes);
    return 0;
}
