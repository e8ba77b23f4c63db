#include "server/compare/ssim.h"

#include <math.h>
#include <stdlib.h>

#include "server/compare/convolve.h"

#define RADIUS_PX 5
#define SIGMA_PX  1.5
#define C1        (0.01 * 0.01)
#define C2        (0.03 * 0.03)

/* What windows sum up: whether a pixel counts, both lumas, their squares, their product. */
enum { WEIGHT, X, Y, XX, YY, XY, SUMS };

static struct convolve_weights window(void)
{
    struct convolve_weights w = {.radius = RADIUS_PX};
    double sum = 0;
    for (int32_t k = -RADIUS_PX; k <= RADIUS_PX; k++)
        sum += w.weight[k + RADIUS_PX] = exp(-k * k / (2 * SIGMA_PX * SIGMA_PX));
    for (int32_t k = 0; k <= 2 * RADIUS_PX; k++) w.weight[k] /= sum;
    return w;
}

static double luma(float *const rgb[3], size_t i)
{
    return 0.2126 * (double)rgb[0][i] + 0.7152 * (double)rgb[1][i] + 0.0722 * (double)rgb[2][i];
}

static void fill(const struct display_pair *s, size_t area, float *const sums[SUMS])
{
    for (size_t i = 0; i < area; i++) {
        const double x = luma(s->reference, i), y = luma(s->test, i);
        sums[WEIGHT][i] = s->counts[i];
        sums[X][i] = (float)x; /* black, that is 0, where the pixel does not count */
        sums[Y][i] = (float)y;
        sums[XX][i] = (float)(x * x);
        sums[YY][i] = (float)(y * y);
        sums[XY][i] = (float)(x * y);
    }
}

static float similarity(float *const sums[SUMS], size_t i)
{
    double v[SUMS];
    for (int k = 0; k < SUMS; k++) v[k] = (double)sums[k][i] / (double)sums[WEIGHT][i];
    const double xx = fmax(v[XX] - v[X] * v[X], 0), yy = fmax(v[YY] - v[Y] * v[Y], 0);
    /* No more than the deviations allow: rounding must not tell what is flat and alike apart. */
    const double most = sqrt(xx * yy), xy = fmin(fmax(v[XY] - v[X] * v[Y], -most), most);
    return (float)((2 * v[X] * v[Y] + C1) * (2 * xy + C2) /
                   ((v[X] * v[X] + v[Y] * v[Y] + C1) * (xx + yy + C2)));
}

static double mean_of(const struct display_pair *s, const float *map)
{
    const bool whole = s->width_px > 2 * RADIUS_PX && s->height_px > 2 * RADIUS_PX;
    const int32_t edge = whole ? RADIUS_PX : 0;
    double sum = 0;
    int64_t count = 0;
    for (int32_t y = edge; y < s->height_px - edge; y++)
        for (int32_t x = edge; x < s->width_px - edge; x++) {
            const size_t i = (size_t)y * (size_t)s->width_px + (size_t)x;
            if (!s->counts[i]) continue;
            sum += (double)map[i];
            count++;
        }
    return count > 0 ? sum / (double)count : 1.0;
}

int ssim_map(const struct display_pair *s, float *map, double *mean)
{
    const size_t area = (size_t)s->width_px * (size_t)s->height_px;
    const struct convolve_weights w = window();
    float *sums[SUMS], *memory = malloc(SUMS * area * sizeof *memory);
    int error = memory ? 0 : ERR_MEMORY;
    for (size_t k = 0; k < SUMS && memory; k++) sums[k] = memory + k * area;
    if (!error) fill(s, area, sums);
    for (int k = 0; !error && k < SUMS; k++)
        error = convolve(sums[k], s->width_px, s->height_px, &w, &w, CONVOLVE_ZERO, sums[k]);
    for (size_t i = 0; !error && i < area; i++) map[i] = s->counts[i] ? similarity(sums, i) : 1.0f;
    if (!error) *mean = mean_of(s, map);
    free(memory);
    return error;
}
