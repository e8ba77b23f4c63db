#include "worker/scene/environment.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "worker/scene/alias_table.h"
#include "worker/shade/elementary.h"

/* A map whose luminance integrates to less is black: densities would leave the range of floats. */
#define TOTAL_MIN 1e-30

struct environment {
    const float *texels; /* the blob's */
    uint32_t width, height;
    float *weights;   /* one a texel: luminance, as lookups inside it have it in the mean */
    float density;    /* per solid angle, of weight 1; 0: a black map */
    float mean, most; /* luminance */
    double *edges;    /* height + 1; 1 - cos from the nearer pole, as proto/scene/environment.h */
    struct alias_cell *cells; /* one a texel */
};

static float luminance(const float rgb[3])
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

static const float *texel_at(const struct environment *e, uint32_t x, uint32_t y)
{
    return e->texels + 3 * ((size_t)y * e->width + x);
}

/* ---- the table ---- */

/* The solid angle of a row's texels in units of 2 pi / width. */
static double row_share(const struct environment *e, uint32_t y)
{
    return e->edges[y + 1] - e->edges[y];
}

/* The mean over a texel of a row's lookups along u: three quarters its own, an eighth each
 * neighbour's. */
static float mean_along(const struct environment *e, uint32_t x, uint32_t y)
{
    const float *before = texel_at(e, x > 0 ? x - 1 : e->width - 1, y);
    const float *after = texel_at(e, x + 1 < e->width ? x + 1 : 0, y);
    return 0.75f * luminance(texel_at(e, x, y)) + 0.125f * (luminance(before) + luminance(after));
}

/* Weighed by its own luminance alone, a dark texel beside a sun would rarely be sampled, and its
 * lookups, which the sun shines into, count for all the more then. */
static void fill_weights(struct environment *e)
{
    const uint32_t last = e->height - 1;
    for (uint32_t y = 0; y <= last; y++) {
        float *row = e->weights + (size_t)y * e->width;
        const uint32_t above = y > 0 ? y - 1 : 0, below = y < last ? y + 1 : last;
        for (uint32_t x = 0; x < e->width; x++)
            row[x] = 0.75f * mean_along(e, x, y) +
                     0.125f * (mean_along(e, x, above) + mean_along(e, x, below));
    }
}

static double integrate(const struct environment *e)
{
    double total = 0.0;
    for (uint32_t y = 0; y < e->height; y++) {
        const float *row = e->weights + (size_t)y * e->width;
        double sum = 0.0;
        for (uint32_t x = 0; x < e->width; x++) sum += (double)row[x];
        total += sum * row_share(e, y);
    }
    return total;
}

/* Lookups are means of texels. */
static void find_most(struct environment *e)
{
    const size_t count = (size_t)e->width * e->height;
    for (size_t i = 0; i < count; i++) e->most = fmaxf(e->most, luminance(e->texels + 3 * i));
}

float environment_mean(const struct environment *e)
{
    return e->mean;
}

float environment_most(const struct environment *e)
{
    return e->most;
}

/* What a texel sends, in units of 2 pi / width: an alias_weight. */
static double weigh_texel(const void *environment, uint32_t i)
{
    const struct environment *e = environment;
    return (double)e->weights[i] * row_share(e, i / e->width);
}

int environment_create(const struct environment_blob *blob, struct environment **out)
{
    struct environment *e = calloc(1, sizeof *e);
    *out = e;
    if (!e) return ERR_MEMORY;
    e->texels = blob->texels;
    e->width = blob->header->width_px;
    e->height = blob->header->height_px;
    e->edges = calloc(e->height + 1u, sizeof *e->edges);
    e->cells = malloc((size_t)e->width * e->height * sizeof *e->cells);
    e->weights = malloc((size_t)e->width * e->height * sizeof *e->weights);
    if (!e->edges || !e->cells || !e->weights) {
        environment_destroy(out);
        return ERR_MEMORY;
    }
    for (uint32_t y = 0; y <= e->height; y++) e->edges[y] = environment_edge(y, e->height);
    fill_weights(e);
    find_most(e);
    const double total = integrate(e), unit = 6.28318530717958648 / (double)e->width;
    e->mean = (float)(total * unit / 12.5663706143591730);
    if (total * unit < TOTAL_MIN) return 0;
    e->density = (float)(1.0 / (total * unit));
    alias_build(weigh_texel, e, e->width * e->height, total, e->cells);
    return 0;
}

void environment_destroy(struct environment **environment)
{
    struct environment *e = *environment;
    *environment = NULL;
    if (!e) return;
    free(e->edges);
    free(e->cells);
    free(e->weights);
    free(e);
}

uint64_t environment_bytes(const struct environment *e)
{
    return sizeof *e + (uint64_t)e->width * e->height * (sizeof *e->cells + sizeof *e->weights) +
           (e->height + 1ull) * sizeof *e->edges;
}

/* ---- from directions to texels ---- */

/* Four texels side by side and one above the other, and how far a lookup is from the first. */
struct corners {
    const float *at[2][2];
    float s, t;
};

static struct corners corners_of(const struct environment *e, struct environment_spot spot)
{
    const float left = floorf(spot.u - 0.5f), upper = floorf(spot.v - 0.5f);
    const uint32_t w = e->width, last = e->height - 1;
    const uint32_t x0 = left < 0.0f ? w - 1 : (uint32_t)left < w ? (uint32_t)left : 0;
    const uint32_t x1 = x0 + 1 < w ? x0 + 1 : 0;
    const uint32_t y0 = upper < 0.0f ? 0 : (uint32_t)upper < last ? (uint32_t)upper : last;
    const uint32_t y1 = upper < 0.0f || y0 == last ? y0 : y0 + 1;
    return (struct corners){.at = {{texel_at(e, x0, y0), texel_at(e, x1, y0)},
                                   {texel_at(e, x0, y1), texel_at(e, x1, y1)}},
                            .s = spot.u - 0.5f - left,
                            .t = spot.v - 0.5f - upper};
}

static uint32_t column_of(const struct environment *e, struct environment_spot spot)
{
    return spot.u < (float)e->width ? (uint32_t)spot.u : 0;
}

static uint32_t row_near(const struct environment *e, struct environment_spot spot)
{
    const uint32_t last = e->height - 1;
    return spot.v < (float)last ? (uint32_t)spot.v : last;
}

void environment_size(const struct environment *e, float *width, float *height)
{
    *width = (float)e->width;
    *height = (float)e->height;
}

void environment_ask(const struct environment *e, struct environment_spot spot)
{
    const struct corners c = corners_of(e, spot);
    for (int y = 0; y < 2; y++)
        for (int x = 0; x < 2; x++) {
            __builtin_prefetch(c.at[y][x]);
            __builtin_prefetch(c.at[y][x] + 2);
        }
    __builtin_prefetch(e->weights + (size_t)row_near(e, spot) * e->width + column_of(e, spot));
}

void environment_read(const struct environment *e, struct environment_spot spot, float radiance[3])
{
    const struct corners c = corners_of(e, spot);
    for (int k = 0; k < 3; k++) {
        const float *const *upper = c.at[0], *const *lower = c.at[1];
        const float top = upper[0][k] + c.s * (upper[1][k] - upper[0][k]);
        const float bottom = lower[0][k] + c.s * (lower[1][k] - lower[0][k]);
        radiance[k] = top + c.t * (bottom - top);
    }
}

/* The row as sampling means it: by where 1 - cos lies between the edges. */
static uint32_t row_of(const struct environment *e, const float d[3], struct environment_spot spot)
{
    const uint32_t last = e->height - 1;
    const bool below = d[1] < 0.0f;
    const double from_pole =
        ((double)d[0] * (double)d[0] + (double)d[2] * (double)d[2]) / (1.0 + fabs((double)d[1]));
    uint32_t row = row_near(e, spot);
    row = below ? last - row : row;
    if (row > 0 && from_pole < e->edges[row]) row--;
    if (row < last && from_pole >= e->edges[row + 1]) row++;
    return below ? last - row : row;
}

float environment_density(const struct environment *e, const float direction[3],
                          struct environment_spot spot)
{
    const size_t row = row_of(e, direction, spot);
    return e->density * e->weights[row * e->width + column_of(e, spot)];
}

/* ---- sampling ---- */

void environment_expect(const struct environment *e, float choice, const float u[2])
{
    if (!(e->density > 0.0f)) return;
    const double x = alias_refine(choice, u);
    __builtin_prefetch(&e->cells[alias_place_of(e->width * e->height, x).cell]);
}

uint32_t environment_choose(const struct environment *e, float choice, const float u[2])
{
    if (!(e->density > 0.0f)) return 0;
    const uint32_t i = alias_choose(e->cells, e->width * e->height, alias_refine(choice, u));
    __builtin_prefetch(e->weights + i);
    return i;
}

struct environment_texel environment_texel_of(const struct environment *e, uint32_t texel)
{
    if (!(e->density > 0.0f)) return (struct environment_texel){0};
    const uint32_t y = texel / e->width, x = texel - y * e->width;
    const bool below = 2 * y >= e->height;
    const uint32_t row = below ? e->height - 1 - y : y;
    return (struct environment_texel){.near = e->edges[row],
                                      .far = e->edges[row + 1],
                                      .column = (float)x,
                                      .below = below,
                                      .density = e->density * e->weights[texel]};
}
