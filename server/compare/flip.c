#include "server/compare/flip.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "server/compare/convolve.h"
#include "server/compare/flip_color.h"

#define PI 3.14159265358979323846

/* Exponents of colour and of features; where large colour errors begin, and what they get. */
#define COLOR_POWER   0.7
#define FEATURE_POWER 0.5
#define LARGE_FROM    0.4
#define LARGE_AT      0.95

#define FEATURE_WIDTH_DEG 0.082 /* of the human edge detector */

/* One picture, as it is perceived: arrays of the picture's size. */
struct perceived {
    float *lab[3];       /* Hunt-adjusted, after the contrast sensitivity filters */
    float *edge, *point; /* lengths of first and second derivatives of luminance */
};

struct flip_work {
    int32_t width, height;
    size_t area;
    double ppd;
    float *spare[4];
};

/* Contrast sensitivity: sums of Gaussians in degrees, table 1 of the paper. */
static const struct {
    double a[2], b[2];
} sensitivity[3] = {
    {{1, 0}, {0.0047, 1e-5}}, {{1, 0}, {0.0053, 1e-5}}, {{34.1, 13.5}, {0.04, 0.025}}};

static int32_t sensitivity_radius(double ppd)
{
    return (int32_t)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * ppd);
}

/* Computes one of the two Gaussians of a channel, not normalised. Returns the sum of its weights.
 *  */
static double gaussian(double b, double ppd, struct convolve_weights *w)
{
    double sum = 0;
    w->radius = sensitivity_radius(ppd);
    for (int32_t k = -w->radius; k <= w->radius; k++)
        sum += w->weight[k + w->radius] = exp(-PI * PI * (k / ppd) * (k / ppd) / b);
    return sum;
}

static void scale(struct convolve_weights *w, double by)
{
    for (int32_t k = 0; k <= 2 * w->radius; k++) w->weight[k] *= by;
}

/* A channel's filter is a sum of separable ones whose weights together sum to one. */
static int filter_channel(const struct flip_work *f, int c, float *values)
{
    double share[2], total = 0;
    struct convolve_weights w[2] = {0};
    int error = 0;
    for (int g = 0; g < 2; g++) {
        const double sum = gaussian(sensitivity[c].b[g], f->ppd, &w[g]);
        share[g] = sensitivity[c].a[g] * sqrt(PI / sensitivity[c].b[g]) * sum * sum;
        total += share[g];
        scale(&w[g], 1 / sum);
    }
    for (int g = 0; g < 2 && !error; g++)
        if (share[g] > 0)
            error = convolve(values, f->width, f->height, &w[g], &w[g], CONVOLVE_REPLICATE,
                             f->spare[g]);
    for (size_t i = 0; i < f->area && !error; i++) {
        double sum = share[0] / total * (double)f->spare[0][i];
        if (share[1] > 0) sum += share[1] / total * (double)f->spare[1][i];
        values[i] = (float)sum;
    }
    return error;
}

/* Weights below zero sum to -1, those above to 1. */
static void balance(struct convolve_weights *w)
{
    double above = 0, below = 0;
    for (int32_t k = 0; k <= 2 * w->radius; k++)
        *(w->weight[k] < 0 ? &below : &above) += fabs(w->weight[k]);
    for (int32_t k = 0; k <= 2 * w->radius; k++) w->weight[k] /= w->weight[k] < 0 ? below : above;
}

/* The Gaussian of features, and its first (with its sign turned) and second derivative. */
static void feature_weights(double ppd, struct convolve_weights w[3])
{
    const double sigma = 0.5 * FEATURE_WIDTH_DEG * ppd;
    const int32_t radius = (int32_t)ceil(3 * sigma);
    double sum = 0;
    for (int d = 0; d < 3; d++) w[d].radius = radius;
    for (int32_t k = -radius; k <= radius; k++) {
        const double g = exp(-k * k / (2 * sigma * sigma));
        sum += w[0].weight[k + radius] = g;
        w[1].weight[k + radius] = -k * g;
        w[2].weight[k + radius] = (k * k / (sigma * sigma) - 1) * g;
    }
    scale(&w[0], 1 / sum);
    balance(&w[1]);
    balance(&w[2]);
}

/* The length of a derivative's two components. */
static int find_feature(const struct flip_work *f, const float *luminance,
                        const struct convolve_weights *derivative,
                        const struct convolve_weights *along, float *out)
{
    int error = convolve(luminance, f->width, f->height, derivative, along, CONVOLVE_REPLICATE,
                         f->spare[0]);
    if (!error)
        error = convolve(luminance, f->width, f->height, along, derivative, CONVOLVE_REPLICATE,
                         f->spare[1]);
    for (size_t i = 0; i < f->area && !error; i++)
        out[i] = (float)hypot((double)f->spare[0][i], (double)f->spare[1][i]);
    return error;
}

static int find_features(const struct flip_work *f, const struct perceived *p)
{
    struct convolve_weights w[3] = {0};
    float *luminance = f->spare[2];
    feature_weights(f->ppd, w);
    for (size_t i = 0; i < f->area; i++) luminance[i] = (float)(((double)p->lab[0][i] + 16) / 116);
    const int error = find_feature(f, luminance, &w[1], &w[0], p->edge);
    return error ? error : find_feature(f, luminance, &w[2], &w[0], p->point);
}

/* `lab` holds luminance and chromas first, and is filtered in place. */
static int perceive(const struct flip_work *f, float *const shown[3], const struct perceived *p)
{
    double v[3];
    int error = 0;
    for (size_t i = 0; i < f->area; i++) {
        const double encoded[3] = {(double)shown[0][i], (double)shown[1][i], (double)shown[2][i]};
        flip_color_opponent(encoded, v);
        for (int c = 0; c < 3; c++) p->lab[c][i] = (float)v[c];
    }
    error = find_features(f, p);
    for (int c = 0; c < 3 && !error; c++) error = filter_channel(f, c, p->lab[c]);
    for (size_t i = 0; i < f->area && !error; i++) {
        const double opponent[3] = {(double)p->lab[0][i], (double)p->lab[1][i],
                                    (double)p->lab[2][i]};
        flip_color_hunt(opponent, v);
        for (int c = 0; c < 3; c++) p->lab[c][i] = (float)v[c];
    }
    return error;
}

/* HyAB distances to [0, 1]: most of it for those below LARGE_FROM of the largest there is. */
static double redistribute(double distance, double largest)
{
    const double v = pow(distance, COLOR_POWER), large = LARGE_FROM * largest;
    if (v < large) return LARGE_AT / large * v;
    return LARGE_AT + (v - large) / (largest - large) * (1 - LARGE_AT);
}

static double error_at(const struct perceived p[2], size_t i, double largest)
{
    double a[3], b[3];
    for (int c = 0; c < 3; c++) {
        a[c] = (double)p[0].lab[c][i];
        b[c] = (double)p[1].lab[c][i];
    }
    const double color = redistribute(flip_color_distance(a, b), largest);
    const double edge = fabs((double)p[0].edge[i] - (double)p[1].edge[i]);
    const double point = fabs((double)p[0].point[i] - (double)p[1].point[i]);
    const double feature = pow(fmax(edge, point) / sqrt(2), FEATURE_POWER);
    return fmin(pow(fmin(color, 1), fmax(1 - feature, 0)), 1);
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void pool(float *sorted, size_t count, struct flip *out)
{
    double sum = 0, so_far = 0;
    int quarter = 0;
    *out = (struct flip){.mean = 0};
    if (count == 0) return;
    qsort(sorted, count, sizeof *sorted, compare_floats);
    for (size_t i = 0; i < count; i++) sum += (double)sorted[i];
    out->mean = sum / (double)count;
    out->max = (double)sorted[count - 1];
    for (size_t i = 0; i < count && quarter < 3; i++) {
        so_far += (double)sorted[i];
        while (quarter < 3 && so_far >= 0.25 * (quarter + 1) * sum)
            out->quartile[quarter++] = (double)sorted[i];
    }
}

static void fill_map(const struct display_pair *pair, const struct perceived p[2], float *sorted,
                     float *map, struct flip *out)
{
    const size_t area = (size_t)pair->width_px * (size_t)pair->height_px;
    const double largest = pow(flip_color_largest(), COLOR_POWER);
    size_t count = 0;
    for (size_t i = 0; i < area; i++) {
        map[i] = pair->counts[i] ? (float)error_at(p, i, largest) : 0.0f;
        if (pair->counts[i]) sorted[count++] = map[i];
    }
    pool(sorted, count, out);
}

int flip_map(const struct display_pair *pair, double ppd, float *map, struct flip *out)
{
    const size_t area = (size_t)pair->width_px * (size_t)pair->height_px;
    struct flip_work f = {pair->width_px, pair->height_px, area, ppd, {NULL}};
    struct perceived p[2];
    assert(ppd >= FLIP_PPD_MIN && ppd <= FLIP_PPD_MAX);
    float *memory = malloc(14 * area * sizeof *memory), *next = memory;
    if (!memory) return ERR_MEMORY;
    for (int k = 0; k < 4; k++, next += area) f.spare[k] = next;
    for (int s = 0; s < 2; s++) {
        for (int c = 0; c < 3; c++, next += area) p[s].lab[c] = next;
        p[s].edge = next;
        p[s].point = next + area;
        next += 2 * area;
    }
    int error = perceive(&f, pair->reference, &p[0]);
    if (!error) error = perceive(&f, pair->test, &p[1]);
    if (!error) fill_map(pair, p, f.spare[3], map, out);
    free(memory);
    return error;
}
