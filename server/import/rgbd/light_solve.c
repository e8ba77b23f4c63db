#include "server/import/rgbd/light_solve.h"

#include <math.h>
#include <stdlib.h>

#include "proto/error.h"

#define TURNS      10
#define SWEEPS     60
#define ALBEDO_MIN 0.02
#define ALBEDO_MAX 0.95
#define TRUST      1.0  /* of the guessed albedo, in shares of what a group's rows tell */
#define OUTLIER    0.25 /* relative: rows that are off by more count less */
#define DIM        0.25 /* of the mean: errors of darker rows are not relative to themselves */

struct work {
    const struct light_system *s;
    double *matrix, *side; /* normal equations */
    double *weight, *sum;  /* rows: weight, irradiance by the lights so far */
    const double *albedo;
    double mean; /* of what is seen */
};

static const float *row_of(const struct work *w, uint32_t i)
{
    return w->s->falls + (size_t)i * w->s->unknowns;
}

/* Sums up what falls on each row, and weighs rows by how well that explains them. */
static void weigh(struct work *w, const double *radiance)
{
    for (uint32_t i = 0; i < w->s->rows; i++) {
        const float *g = row_of(w, i);
        double sum = (double)w->s->known[i];
        for (uint32_t j = 0; j < w->s->unknowns; j++) sum += (double)g[j] * radiance[j];
        const double seen = (double)w->s->seen[i], scale = seen + DIM * w->mean;
        const double off = (seen - w->albedo[w->s->group[i]] * sum / M_PI) / (scale * OUTLIER);
        w->sum[i] = sum;
        w->weight[i] = 1 / (scale * scale * (1 + off * off));
    }
}

static void build(struct work *w)
{
    const uint32_t n = w->s->unknowns;
    for (size_t i = 0; i < (size_t)n * n; i++) w->matrix[i] = 0;
    for (uint32_t j = 0; j < n; j++) {
        const double guess = fmax((double)w->s->guess[j], 1e-3 * w->mean);
        const double trust = (double)w->s->trust[j] / (guess * guess);
        w->matrix[(size_t)j * n + j] = trust;
        w->side[j] = trust * (double)w->s->guess[j];
    }
    for (uint32_t i = 0; i < w->s->rows; i++) {
        const float *g = row_of(w, i);
        const double a = w->albedo[w->s->group[i]] / M_PI;
        const double left = (double)w->s->seen[i] - a * (double)w->s->known[i];
        for (uint32_t j = 0; j < n; j++) {
            if (!(g[j] > 0)) continue;
            const double by = w->weight[i] * a * (double)g[j];
            w->side[j] += by * left;
            for (uint32_t k = 0; k < n; k++) w->matrix[(size_t)j * n + k] += by * a * (double)g[k];
        }
    }
}

/* Gauss and Seidel's sweeps, with what would be negative held at 0. */
static void sweep(const struct work *w, double *radiance)
{
    const uint32_t n = w->s->unknowns;
    for (int step = 0; step < SWEEPS; step++)
        for (uint32_t j = 0; j < n; j++) {
            const double *row = w->matrix + (size_t)j * n;
            double left = w->side[j];
            for (uint32_t k = 0; k < n; k++)
                if (k != j) left -= row[k] * radiance[k];
            radiance[j] = row[j] > 0 ? fmax(left / row[j], 0) : 0;
        }
}

static void find_albedo(const struct work *w, const double guess[LIGHT_GROUPS],
                        double albedo[LIGHT_GROUPS])
{
    double up[LIGHT_GROUPS] = {0}, down[LIGHT_GROUPS] = {0};
    for (uint32_t i = 0; i < w->s->rows; i++) {
        const double e = w->sum[i] / M_PI, square = w->weight[i] * e * e;
        const uint8_t k = w->s->group[i];
        up[k] += w->weight[i] * e * (double)w->s->seen[i] + TRUST * square * guess[k];
        down[k] += (1 + TRUST) * square;
    }
    for (int k = 0; k < LIGHT_GROUPS; k++)
        if (down[k] > 0) albedo[k] = fmin(fmax(up[k] / down[k], ALBEDO_MIN), ALBEDO_MAX);
}

static void solve(struct work *w, double albedo[LIGHT_GROUPS], double *radiance)
{
    double guess[LIGHT_GROUPS];
    for (int k = 0; k < LIGHT_GROUPS; k++) guess[k] = albedo[k];
    for (uint32_t j = 0; j < w->s->unknowns; j++) radiance[j] = (double)w->s->guess[j];
    for (uint32_t i = 0; i < w->s->rows; i++) w->mean += (double)w->s->seen[i] / (double)w->s->rows;
    if (!(w->mean > 0)) return;
    for (int turn = 0; turn < TURNS; turn++) {
        weigh(w, radiance);
        build(w);
        sweep(w, radiance);
        weigh(w, radiance);
        find_albedo(w, guess, albedo);
    }
}

int light_solve(const struct light_system *s, double albedo[LIGHT_GROUPS], double *radiance)
{
    const size_t n = s->unknowns > 0 ? s->unknowns : 1, rows = s->rows > 0 ? s->rows : 1;
    struct work w = {.s = s,
                     .matrix = malloc(n * n * sizeof(double)),
                     .side = malloc(n * sizeof(double)),
                     .weight = malloc(rows * sizeof(double)),
                     .sum = malloc(rows * sizeof(double)),
                     .albedo = albedo};
    const int rc = w.matrix && w.side && w.weight && w.sum ? 0 : ERR_MEMORY;
    if (rc == 0) solve(&w, albedo, radiance);
    free(w.matrix);
    free(w.side);
    free(w.weight);
    free(w.sum);
    return rc;
}
