#include "server/reconstruct/residual/residual_error.h"

#include <math.h>
#include <string.h>

#include "proto/error.h"

/* Probes do not see that weights follow the noise, and few samples do not show all light there is:
 * so much more variance than is seen, as real scenes have it at 4 and 16 samples. It fades where
 * passes keep the noise. */
#define UNSEEN 1.0f

/* The last pass has this share of all bias, or less. */
#define LAST_PASS_SHARE 0.5f

/* Squares of noise are so many times their mean in one picture of twelve: less is no bias. */
#define NOISE_TIMES 3.0f

/* The pixels around count as so many more samples. */
#define AROUND_WEIGHT 6.0f

/* The plain mean's variance over what its halves say, beyond which halves are thought to agree by
 * chance. Where emission is seen, all that they do not say is emission's. */
#define CHANCE 8.0f

#define VARIANCE_MAX 1e30f

/* Half the sides of boxes. In the first, squares are averaged, too. */
static const int32_t radii[] = {2, RESIDUAL_ERROR_REACH_PX};
enum { RADII = sizeof radii / sizeof radii[0] };

/* What is added up over boxes. */
enum {
    COUNT,  /* pixels that are filtered */
    BIASED, /* what they are apart from their plain means, and the same of probes */
    NOISES,
    WIDE = NOISES + RESIDUAL_SIGNED, /* those that all boxes have */
    BEFORE = WIDE,                   /* squares: of noise, */
    AFTER,                           /* of what is left of it, as probes */
    HALVES,                          /* and halves tell */
    CHANGED,                         /* by the last pass, beyond noise */
    EMITS,                           /* whether emission is seen */
    PLANES
};

struct planes {
    const struct residual_probes *probes;
    const struct residual_field *field;
    const struct patch *patch;
    struct rect block, wide; /* and as far around as boxes reach */
    size_t area, wide_area;
    float *of[PLANES];  /* over `wide` */
    float *sum[PLANES]; /* over boxes, of `block` */
    float *rows;        /* over columns of boxes, of `wide` rows and `block` columns */
    float *bias;        /* of `block` */
};

static size_t index_in(struct rect r, int32_t x, int32_t y)
{
    return (size_t)(y - r.y0) * (size_t)rect_width(r) + (size_t)(x - r.x0);
}

static size_t place_of(const struct planes *p, int32_t x, int32_t y)
{
    return residual_at(&p->field->features.shape, x - p->patch->rect.x0, y - p->patch->rect.y0);
}

static void *planes_create(struct planes *p)
{
    p->wide = rect_intersect(rect_grow(p->block, RESIDUAL_ERROR_REACH_PX), p->patch->rect);
    p->area = (size_t)rect_area(p->block), p->wide_area = (size_t)rect_area(p->wide);
    const size_t floats = (PLANES + 1) * (p->wide_area + p->area);
    float *next = scratch_take(p->patch->scratch, floats * sizeof *next);
    if (!next) return NULL;
    memset(next, 0, floats * sizeof *next);
    void *const memory = next;
    for (int k = 0; k < PLANES; k++, next += p->wide_area) p->of[k] = next;
    p->rows = next, next += p->wide_area;
    for (int k = 0; k < PLANES; k++, next += p->area) p->sum[k] = next;
    p->bias = next;
    return memory;
}

/* -- pixels -- */

/* Squared, how far the picture is from what it was before the last pass; *apart becomes the mean
 * over R, G and B of how far it is from the plain mean. */
static float change_of(const struct planes *p, size_t i, size_t at, float *apart)
{
    const struct residual_features *f = &p->field->features;
    const struct residual_light *l = p->field->light;
    float squares = 0.0f;
    *apart = 0.0f;
    for (size_t c = 0; c < 3; c++) {
        const size_t k = c * f->shape.plane + at;
        const float now =
            f->albedo[k] * (l[RESIDUAL_DIRECT].half[0][k] + l[RESIDUAL_INDIRECT].half[0][k]) +
            f->tint[k] * l[RESIDUAL_REST].half[0][k];
        const float then = f->albedo[k] * (l[RESIDUAL_DIRECT].filtered[0][k] +
                                           l[RESIDUAL_INDIRECT].filtered[0][k]) +
                           f->tint[k] * l[RESIDUAL_REST].filtered[0][k];
        const float plain = p->field->joined
                                ? p->field->joined[k]
                                : (p->patch->path_radiance[c][i] - p->patch->path_emission[c][i]) /
                                      p->patch->paths.spp[i];
        squares += (now - then) * (now - then) / 3.0f;
        *apart += (now - plain) / 3.0f;
    }
    return squares;
}

static float emission_of(const struct patch *p, size_t i)
{
    return p->path_emission[0][i] + p->path_emission[1][i] + p->path_emission[2][i];
}

/* Numbers of a pixel; `to` is its place in the planes. */
static void fill_pixel(const struct planes *p, int32_t x, int32_t y, size_t to)
{
    const size_t i = patch_pixel(p->patch, x, y), at = place_of(p, x, y);
    const float noise = p->probes->noise[at];
    float noise_changed = 0.0f;
    p->of[EMITS][to] = emission_of(p->patch, i) > 0.0f ? 1.0f : 0.0f;
    if (!residual_is_filtered(&p->field->features, at)) return;
    p->of[COUNT][to] = 1.0f;
    p->of[BEFORE][to] = noise * noise;
    for (uint32_t k = 0; k < RESIDUAL_SIGNED; k++) {
        const float left = residual_probe_after(p->field, k, at);
        const float change = left - residual_probe_before(p->field, k, at);
        p->of[AFTER][to] += left * left / RESIDUAL_SIGNED;
        noise_changed += change * change / RESIDUAL_SIGNED;
        p->of[NOISES + k][to] = left - residual_probe_sign(x, y, k) * noise;
    }
    const float halves = residual_probe_after(p->field, RESIDUAL_SIGNED, at);
    p->of[HALVES][to] = halves * halves;
    p->of[CHANGED][to] = change_of(p, i, at, &p->of[BIASED][to]) - noise_changed;
}

static void fill(const struct planes *p)
{
    size_t to = 0;
    for (int32_t y = p->wide.y0; y < p->wide.y1; y++)
        for (int32_t x = p->wide.x0; x < p->wide.x1; x++, to++) fill_pixel(p, x, y, to);
}

/* -- boxes -- */

static int32_t min_i32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* Sums over x - radius .. x + radius, for one row of `wide` and the block's columns. */
static void sum_row(const struct planes *p, const float *row, int32_t radius, float *out)
{
    const int32_t width = rect_width(p->block), left = p->block.x0 - p->wide.x0;
    for (int32_t step = -radius; step <= radius; step++) {
        const int32_t from = step < -left ? -left - step : 0;
        const int32_t to = min_i32(width, rect_width(p->wide) - left - step);
        const float *in = row + left + step;
        for (int32_t x = from; x < to; x++) out[x] += in[x];
    }
}

/* Sums of plane k over boxes, which end with the picture, in one order wherever the block lies. */
static void sum_boxes(const struct planes *p, int k, int32_t radius)
{
    const int32_t width = rect_width(p->block), rows = rect_height(p->wide);
    memset(p->rows, 0, (size_t)width * (size_t)rows * sizeof *p->rows);
    memset(p->sum[k], 0, p->area * sizeof *p->rows);
    for (int32_t y = 0; y < rows; y++)
        sum_row(p, p->of[k] + (size_t)y * (size_t)rect_width(p->wide), radius,
                p->rows + (size_t)y * (size_t)width);
    for (int32_t y = p->block.y0; y < p->block.y1; y++) {
        float *out = p->sum[k] + index_in(p->block, p->block.x0, y);
        for (int32_t v = y - radius; v <= y + radius; v++) {
            if (v < p->wide.y0 || v >= p->wide.y1) continue;
            const float *in = p->rows + (size_t)(v - p->wide.y0) * (size_t)width;
            for (int32_t x = 0; x < width; x++) out[x] += in[x];
        }
    }
}

/* What means over boxes are apart, squared, beyond what noise makes of them: the most over all. */
static void find_bias(const struct planes *p, int32_t radius)
{
    for (int k = 0; k < WIDE; k++) sum_boxes(p, k, radius);
    for (size_t i = 0; i < p->area; i++) {
        const float count = p->sum[COUNT][i];
        float excess = p->sum[BIASED][i] * p->sum[BIASED][i];
        for (int k = 0; k < RESIDUAL_SIGNED; k++)
            excess -= NOISE_TIMES / RESIDUAL_SIGNED * p->sum[NOISES + k][i] * p->sum[NOISES + k][i];
        if (excess > p->bias[i] * count * count) p->bias[i] = excess / (count * count);
    }
}

/* -- variances -- */

/* A mean over the box, mixed with the pixel's own number by what its samples weigh. */
static float smooth(const struct planes *p, int k, size_t i, size_t own, float samples)
{
    const float around = p->sum[k][i] / p->sum[COUNT][i];
    const float weight = (samples - 1.0f) / (samples - 1.0f + AROUND_WEIGHT);
    return around + weight * (p->of[k][own] - around);
}

/* Of what is filtered, as the mean over R, G and B; `plain` is that of the plain mean. */
static float noise_at(const struct planes *p, size_t i, size_t own, float samples, float plain)
{
    const float before = smooth(p, BEFORE, i, own, samples);
    const float after =
        fmaxf(smooth(p, AFTER, i, own, samples), smooth(p, HALVES, i, own, samples));
    const bool emits = p->sum[EMITS][i] > 0.0f;
    const float chance = emits ? 1.0f : CHANCE;
    const float told = chance * p->sum[BEFORE][i] / p->sum[COUNT][i];
    const float most = fmaxf(after, before);
    const float kept = most > 0.0f ? fminf(after, before) / most : 0.0f;
    const float strata = plain < chance * before ? plain / before : chance;
    const float share = kept * strata + (1.0f - kept) * (1.0f + UNSEEN);
    return share * after + fmaxf(plain - told, 0.0f);
}

static void put_pixel(const struct planes *p, int32_t x, int32_t y, float *const variance[3])
{
    const size_t i = index_in(p->block, x, y), own = index_in(p->wide, x, y);
    const float samples = p->patch->paths.spp[patch_pixel(p->patch, x, y)];
    const float part = p->field->own ? p->field->own[place_of(p, x, y)] : 1.0f;
    for (int c = 0; c < 3; c++) variance[c][i] *= part;
    const float plain = (variance[0][i] + variance[1][i] + variance[2][i]) / 3.0f;
    const float noise = noise_at(p, i, own, samples, plain);
    const float changed = fmaxf(p->sum[CHANGED][i] / p->sum[COUNT][i], 0.0f);
    for (int c = 0; c < 3; c++) {
        const float share = plain > 0.0f ? variance[c][i] / plain : 1.0f;
        const float sum = share * noise + p->bias[i] + changed / LAST_PASS_SHARE;
        variance[c][i] = sum < VARIANCE_MAX ? sum : VARIANCE_MAX;
    }
}

int residual_error_find(const struct residual_probes *probes, const struct patch *patch,
                        const struct residual_field *field, struct rect block,
                        float *const variance[3])
{
    struct planes p = {.probes = probes, .field = field, .patch = patch, .block = block};
    void *memory = planes_create(&p);
    if (!memory) return ERR_MEMORY;
    fill(&p);
    for (int k = RADII - 1; k >= 0; k--) find_bias(&p, radii[k]);
    for (int k = WIDE; k < PLANES; k++) sum_boxes(&p, k, radii[0]);
    for (int32_t y = block.y0; y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x++)
            if (residual_is_filtered(&field->features, place_of(&p, x, y)))
                put_pixel(&p, x, y, variance);
    scratch_give(patch->scratch, memory);
    return 0;
}
