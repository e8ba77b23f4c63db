#include "server/reconstruct/indirect_blend.h"

#include <math.h>

#include "server/reconstruct/indirect.h"

#define LEVELS         4
#define NOISE_SAMPLES  64 /* below, noise counts twice */
#define FOUR_PI        12.5663706f
#define RELATIVE_LEAST 1e-30f /* darker channels have no say */

struct blend {
    const struct indirect_rule *rule;
    const struct indirect_kernels *kernels;
    struct indirect_place *place;
    uint32_t count;
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

static void carve(struct blend *b)
{
    uint32_t next = 0;
    for (uint32_t c = 0; c < b->count; c++) b->channels[c] = indirect_place_spare(b->place, next++);
    b->width = indirect_place_spare(b->place, next++);
    b->beta = indirect_place_spare(b->place, next++);
    for (uint32_t c = 0; c < between_count(b->count); c++)
        b->between[c] = indirect_place_spare(b->place, next++);
    for (uint32_t k = 0; k < LEVELS; k++) {
        for (uint32_t c = 0; c < b->count; c++)
            b->level[k][c] = indirect_place_spare(b->place, next++);
        b->square[k] = indirect_place_spare(b->place, next++);
    }
}

/* F_0 .. F_3 over `rect`. */
static void filter_levels(const struct blend *b, struct rect rect)
{
    const struct indirect_pass pass = {.kernels = b->kernels,
                                       .lines = true,
                                       .reach = indirect_reach_px(b->rule->most_px),
                                       .count = b->count};
    const struct rect tall = indirect_pass_tall(b->place, rect, pass.reach);
    float scale = 1.0f;
    indirect_widths(b->rule, b->kernels, b->place, tall, b->beta);
    for (uint32_t k = 0; k < LEVELS; k++, scale *= 0.5f) {
        indirect_set_widths(b->rule, b->place, tall, b->beta, scale);
        indirect_pass_run(&pass, b->place, rect, (const float *const *)b->channels, b->between,
                          b->level[k]);
    }
}

/* Noise and the levels' differences, squared. */
static void square_differences(const struct blend *b, struct rect rect)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = indirect_place_index(b->place, rect.x0, y);
        const size_t end = first + (size_t)rect_width(rect);
        for (uint32_t k = 0; k < LEVELS; k++) {
            for (size_t i = first; i < end; i++) b->square[k][i] = 0.0f;
            for (uint32_t c = 0; c < b->count; c++) {
                const float *fine = b->level[k > 0 ? k : LEVELS - 1][c];
                const float *other = k > 0 ? b->level[k - 1][c] : b->channels[c];
                const float *whole = b->level[0][c];
                for (size_t i = first; i < end; i++) {
                    const float by = whole[i] > RELATIVE_LEAST ? whole[i] : 0.0f;
                    const float d = by > 0.0f ? (fine[i] - other[i]) / by : 0.0f;
                    b->square[k][i] += d * d;
                }
            }
        }
    }
}

/* Smooths the squares over `rect`. */
static void smooth(const struct blend *b, struct rect rect)
{
    const struct indirect_pass pass = {.kernels = b->kernels,
                                       .reach = indirect_reach_px(b->rule->smooth_most_px),
                                       .count = LEVELS};
    const struct rect tall = indirect_pass_tall(b->place, rect, pass.reach);
    for (int32_t y = tall.y0; y < tall.y1; y++) {
        const size_t first = indirect_place_index(b->place, tall.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(tall); i++) {
            const float pixel = b->place->pixel[i];
            const float least = b->rule->smooth_least_px * pixel;
            const float most = b->rule->smooth_most_px * pixel;
            b->width[i] = fminf(fmaxf(b->beta[i], least), most);
        }
    }
    indirect_set_widths(b->rule, b->place, tall, b->width, 1.0f);
    indirect_pass_run(&pass, b->place, rect, (const float *const *)b->square, b->between,
                      b->square);
}

/* How much of what is wider than level k - 1 may stand. */
static float share_of(const struct blend *b, uint32_t k, float factor, float beta, size_t i)
{
    const float sigma = beta / b->place->pixel[i]; /* not 0: measured */
    const float pixels = fmaxf(FOUR_PI * sigma * sigma, 1.0f);
    const float noise = factor * b->square[0][i] / pixels, difference = b->square[k][i];
    return difference > noise ? 1.0f - noise / difference : 0.0f;
}

static void mix_pixel(const struct blend *b, float factor, size_t i)
{
    float width = b->beta[i] * 0.125f;
    float out[INDIRECT_CHANNELS_MAX];
    for (uint32_t c = 0; c < b->count; c++) out[c] = b->level[LEVELS - 1][c][i];
    for (uint32_t k = LEVELS - 1; k > 0; k--) {
        const float beta = b->beta[i] / (float)(1u << k);
        const float share = share_of(b, k, factor, beta, i);
        for (uint32_t c = 0; c < b->count; c++) {
            const float wide = b->level[k - 1][c][i];
            out[c] = wide + share * (out[c] - wide);
        }
        width = 2.0f * beta + share * (width - 2.0f * beta);
    }
    for (uint32_t c = 0; c < b->count; c++) b->channels[c][i] = out[c];
    b->width[i] = width;
}

void indirect_blend(const struct plan *plan, const struct indirect_rule *rule,
                    const struct indirect_kernels *kernels, struct indirect_place *place,
                    struct rect rect, uint32_t count)
{
    const uint32_t n = plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
    struct blend b = {.rule = rule, .kernels = kernels, .place = place, .count = count};
    const int32_t reach = indirect_reach_px(rule->smooth_most_px);
    const struct rect wide = rect_intersect(rect_grow(rect, reach), place->rect);
    carve(&b);
    filter_levels(&b, wide);
    square_differences(&b, wide);
    smooth(&b, rect);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = indirect_place_index(place, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            if (place->pixel[i] > 0.0f) mix_pixel(&b, n < NOISE_SAMPLES ? 2.0f : 1.0f, i);
    }
}
