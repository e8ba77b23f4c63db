#include "server/reconstruct/indirect/indirect_variance.h"

#include <math.h>
#include <stdlib.h>

int32_t indirect_variance_reach(const struct indirect_rule *rule)
{
    return indirect_reach_px(rule->smooth_max_px);
}

static float *spare(const struct indirect_variance *s, uint32_t k)
{
    return indirect_neighbourhood_spare(s->around, s->own + k);
}

/* Returns whether F has one width per pixel, so that F' still has to be computed. */
static bool is_rule(const struct indirect_variance *s)
{
    return s->plan->indirect_filter == INDIRECT_FILTER_CONSTANT ||
           s->plan->indirect_filter == INDIRECT_FILTER_LINEAR;
}

/* F' of the channels and of their halves. */
static void filter_narrower(const struct indirect_variance *s, struct rect wide)
{
    const struct indirect_pass pass = {.kernels = s->kernels,
                                       .lines = s->plan->indirect_filter == INDIRECT_FILTER_LINEAR,
                                       .reach = indirect_reach_px(s->rule->most_px),
                                       .count = 6};
    const struct rect tall = indirect_pass_tall(s->around, wide, pass.reach);
    float *channels[6], *between[6];
    for (uint32_t k = 0; k < 6; k++) {
        channels[k] = indirect_neighbourhood_spare(s->around, s->narrower[k]);
        between[k] = spare(s, 6 + k);
    }
    indirect_set_widths(s->rule, s->around, tall, indirect_neighbourhood_spare(s->around, s->width),
                        s->ratio);
    indirect_pass_run(&pass, s->around, wide, (const float *const *)channels, between, channels);
}

/* Computes, for channel c, the squared noise and the squared difference of F and F' beyond their
 * noise. */
static void square(const struct indirect_variance *s, uint32_t c, struct rect wide)
{
    const float *mean = indirect_neighbourhood_spare(s->around, s->mean + c);
    const float *half = indirect_neighbourhood_spare(s->around, s->half + c);
    const float *narrow_mean = indirect_neighbourhood_spare(s->around, s->narrower[c]);
    const float *narrow_half = indirect_neighbourhood_spare(s->around, s->narrower[3 + c]);
    float *noise = spare(s, c), *bias = spare(s, 3 + c);
    for (int32_t y = wide.y0; y < wide.y1; y++) {
        const size_t first = indirect_neighbourhood_index(s->around, wide.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(wide); i++) {
            const float off = half[i] - mean[i];
            const float narrow_off = narrow_half[i] - narrow_mean[i];
            const float step = mean[i] - narrow_mean[i], step_noise = off - narrow_off;
            noise[i] = off * off;
            bias[i] = step * step - step_noise * step_noise;
        }
    }
}

static void smooth(const struct indirect_variance *s, struct rect rect)
{
    const struct indirect_pass pass = {
        .kernels = s->kernels, .reach = indirect_variance_reach(s->rule), .count = 6};
    const struct rect tall = indirect_pass_tall(s->around, rect, pass.reach);
    const float *beta = indirect_neighbourhood_spare(s->around, s->width);
    float *squares[6], *between[6], *width = spare(s, 12);
    for (uint32_t k = 0; k < 6; k++) {
        squares[k] = spare(s, k);
        between[k] = spare(s, 6 + k);
    }
    for (int32_t y = tall.y0; y < tall.y1; y++) {
        const size_t first = indirect_neighbourhood_index(s->around, tall.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(tall); i++) {
            const float pixel = s->around->pixel[i];
            const float least = s->rule->smooth_min_px * pixel;
            const float most = s->rule->smooth_max_px * pixel;
            width[i] = fminf(fmaxf(beta[i], least), most);
        }
    }
    indirect_set_widths(s->rule, s->around, tall, width, 1.0f);
    indirect_pass_run(&pass, s->around, rect, (const float *const *)squares, between, squares);
}

void indirect_variance_find(const struct indirect_variance *s, struct rect wide, struct rect rect)
{
    if (is_rule(s)) filter_narrower(s, wide);
    for (uint32_t c = 0; c < 3; c++) square(s, c, wide);
    smooth(s, rect);
    const float left = 1.0f - s->ratio * s->ratio, factor = 1.0f / (left * left);
    for (uint32_t c = 0; c < 3; c++) {
        float *noise = spare(s, c), *bias = spare(s, 3 + c);
        for (int32_t y = rect.y0; y < rect.y1; y++) {
            const size_t first = indirect_neighbourhood_index(s->around, rect.x0, y);
            for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
                noise[i] = fmaxf(noise[i], 0.0f) + factor * fmaxf(bias[i], 0.0f);
        }
    }
}
