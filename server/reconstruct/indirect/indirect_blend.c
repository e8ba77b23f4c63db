#include "server/reconstruct/indirect/indirect_blend.h"

#include <math.h>

#include "server/reconstruct/indirect/indirect.h"

#define LEVELS       4
#define FOUR_PI      12.5663706f
#define RELATIVE_MIN 1e-30f /* darker channels have no say */

/* The mean that tells noise: pixels it looks at to both sides, and the share of independent noise's
 * variance in what it takes off a pixel: 1 - 2 a^2 + s^2, of weights w = exp(-d^2 / (2 * 1.25^2))
 * for d = -3 .. 3 with a = 1 / sum w of the pixel itself and s = sum w^2 / (sum w)^2 along each
 * axis. */
#define NOISE_SIGMA_PX 1.25f
#define NOISE_REACH_PX 4
#define NOISE_TAKEN    0.846f

struct blend {
    const struct indirect_rule *rule;
    const struct indirect_kernels *kernels;
    struct indirect_neighbourhood *around;
    const float *counts; /* of samples; NULL: the plan's */
    uint32_t count, voters;
    float *channels[INDIRECT_CHANNELS_MAX]; /* what was measured; the result */
    float *width, *beta;                    /* of F_0 */
    float *between[INDIRECT_CHANNELS_MAX];  /* two passes */
    float *level[LEVELS][INDIRECT_CHANNELS_MAX];
    float *square[LEVELS]; /* of noise; then of each level's difference from the one before */
};

/* Smoothing runs through `between`, too. */
static uint32_t between_count(uint32_t count)
{
    return count > LEVELS ? count : LEVELS;
}

uint32_t indirect_blend_spares(uint32_t count)
{
    return count + 2 + between_count(count) + LEVELS * count + LEVELS;
}

uint32_t indirect_blend_narrower(uint32_t count, uint32_t c)
{
    return count + 2 + between_count(count) + c;
}

static void carve(struct blend *b)
{
    uint32_t next = 0;
    for (uint32_t c = 0; c < b->count; c++)
        b->channels[c] = indirect_neighbourhood_spare(b->around, next++);
    b->width = indirect_neighbourhood_spare(b->around, next++);
    b->beta = indirect_neighbourhood_spare(b->around, next++);
    for (uint32_t c = 0; c < between_count(b->count); c++)
        b->between[c] = indirect_neighbourhood_spare(b->around, next++);
    for (uint32_t k = 0; k < LEVELS; k++) {
        for (uint32_t c = 0; c < b->count; c++)
            b->level[k][c] = indirect_neighbourhood_spare(b->around, next++);
        b->square[k] = indirect_neighbourhood_spare(b->around, next++);
    }
}

/* F_k over `rect`; beta is set around it. */
static void filter_level(const struct blend *b, uint32_t k, float scale, struct rect rect)
{
    const struct indirect_pass pass = {.kernels = b->kernels,
                                       .lines = true,
                                       .reach = indirect_reach_px(b->rule->most_px),
                                       .count = b->count};
    const struct rect tall = indirect_pass_tall(b->around, rect, pass.reach);
    indirect_set_widths(b->rule, b->around, tall, b->beta, scale);
    indirect_pass_run(&pass, b->around, rect, (const float *const *)b->channels, b->between,
                      b->level[k]);
}

/* The narrow mean over `rect`. */
static void filter_noise(const struct blend *b, struct rect rect, float *const out[])
{
    const struct indirect_pass pass = {
        .kernels = b->kernels, .reach = NOISE_REACH_PX, .count = b->count};
    const struct rect tall = indirect_pass_tall(b->around, rect, pass.reach);
    for (int32_t y = tall.y0; y < tall.y1; y++) {
        const size_t first = indirect_neighbourhood_index(b->around, tall.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(tall); i++)
            b->width[i] = NOISE_SIGMA_PX * b->around->pixel[i];
    }
    indirect_set_widths(b->rule, b->around, tall, b->width, 1.0f);
    indirect_pass_run(&pass, b->around, rect, (const float *const *)b->channels, b->between, out);
}

/* out = the squared difference of two levels over `rect`, relative to F_0. */
static void square_difference(const struct blend *b, struct rect rect, float *const one[],
                              float *const other[], float *out)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = indirect_neighbourhood_index(b->around, rect.x0, y);
        const size_t end = first + (size_t)rect_width(rect);
        for (size_t i = first; i < end; i++) out[i] = 0.0f;
        for (uint32_t c = 0; c < b->voters; c++) {
            const float *whole = b->level[0][c], *of = one[c], *from = other[c];
            for (size_t i = first; i < end; i++) {
                const float by = whole[i] > RELATIVE_MIN ? whole[i] : 0.0f;
                const float d = by > 0.0f ? (of[i] - from[i]) / by : 0.0f;
                out[i] += d * d;
            }
        }
    }
}

/* F_0 .. F_3 over `rect`, noise and the levels' differences. */
static void filter_levels(const struct blend *b, struct rect rect)
{
    float scale = 1.0f;
    const int32_t reach = indirect_reach_px(b->rule->most_px);
    indirect_widths(b->rule, b->kernels, b->around, b->counts,
                    indirect_pass_tall(b->around, rect, reach), b->beta);
    filter_level(b, 0, scale, rect);
    filter_noise(b, rect, b->level[1]);
    square_difference(b, rect, b->channels, b->level[1], b->square[0]);
    for (uint32_t k = 1; k < LEVELS; k++) {
        scale *= b->rule->ratio;
        filter_level(b, k, scale, rect);
        square_difference(b, rect, b->level[k], b->level[k - 1], b->square[k]);
    }
}

/* Smooths the squares over `rect`. */
static void smooth(const struct blend *b, struct rect rect)
{
    const struct indirect_pass pass = {
        .kernels = b->kernels, .reach = indirect_reach_px(b->rule->smooth_max_px), .count = LEVELS};
    const struct rect tall = indirect_pass_tall(b->around, rect, pass.reach);
    for (int32_t y = tall.y0; y < tall.y1; y++) {
        const size_t first = indirect_neighbourhood_index(b->around, tall.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(tall); i++) {
            const float pixel = b->around->pixel[i];
            const float least = b->rule->smooth_min_px * pixel;
            const float most = b->rule->smooth_max_px * pixel;
            b->width[i] = fminf(fmaxf(b->beta[i], least), most);
        }
    }
    indirect_set_widths(b->rule, b->around, tall, b->width, 1.0f);
    indirect_pass_run(&pass, b->around, rect, (const float *const *)b->square, b->between,
                      b->square);
}

/* What follows from the ratio of widths: r^2, w and c of the header. */
struct steps {
    float square, differs, counts;
    float finest; /* sigma_3 over sigma_0 */
};

static struct steps steps_of(float ratio)
{
    const float square = ratio * ratio, common = 2.0f * square / (1.0f + square);
    return (struct steps){
        .square = square,
        .differs = 1.0f + square - 2.0f * common, /* (1 - r^2)^2 / (1 + r^2): not 0, r < 1 */
        .counts = 1.0f - common,
        .finest = ratio * ratio * ratio,
    };
}

/* The result, and the same of the next narrower level each, which takes the place of F_0. */
static void mix_pixel(const struct blend *b, const struct steps *steps, size_t i)
{
    float beta = b->beta[i] * steps->finest, width = beta;
    float sigma = beta / b->around->pixel[i]; /* not 0: measured */
    float noise = b->square[0][i] / (NOISE_TAKEN * fmaxf(FOUR_PI * sigma * sigma, 1.0f));
    float out[INDIRECT_CHANNELS_MAX], narrow[INDIRECT_CHANNELS_MAX];
    for (uint32_t c = 0; c < b->count; c++) out[c] = narrow[c] = b->level[LEVELS - 1][c][i];
    for (uint32_t k = LEVELS - 1; k > 0; k--) {
        const float difference = b->square[k][i], counts = steps->counts * noise;
        const float share = difference > counts ? 1.0f - counts / difference : 0.0f;
        for (uint32_t c = 0; c < b->count; c++) {
            const float wide = b->level[k - 1][c][i];
            const float step = b->level[k][c][i];
            out[c] = wide + share * (out[c] - wide);
            narrow[c] = step + share * (narrow[c] - step);
        }
        beta /= b->rule->ratio;
        width = beta + share * (width - beta);
        noise = steps->square * fminf(noise, difference / steps->differs);
    }
    for (uint32_t c = 0; c < b->count; c++) {
        b->channels[c][i] = out[c];
        b->level[0][c][i] = narrow[c];
    }
    b->width[i] = width;
}

void indirect_blend(const struct indirect_rule *rule, const struct indirect_kernels *kernels,
                    struct indirect_neighbourhood *around, const float *counts, struct rect rect,
                    uint32_t count, uint32_t voters)
{
    struct blend b = {.rule = rule,
                      .kernels = kernels,
                      .around = around,
                      .counts = counts,
                      .count = count,
                      .voters = voters};
    const int32_t reach = indirect_reach_px(rule->smooth_max_px);
    const struct rect wide = rect_intersect(rect_grow(rect, reach), around->rect);
    const struct steps steps = steps_of(rule->ratio);
    carve(&b);
    filter_levels(&b, wide);
    smooth(&b, rect);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = indirect_neighbourhood_index(around, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            if (around->pixel[i] > 0.0f) mix_pixel(&b, &steps, i);
    }
}
