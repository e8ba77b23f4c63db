#include "server/reconstruct/indirect_width.h"

#include <math.h>

#include "server/reconstruct/indirect.h"

#define LINES        512.0f /* what pixels below are counted at */
#define SAMPLES      16.0f
#define BANDLIMIT    (2.0f / 2.8f)
#define BETA_LEAST   0.6f
#define FALLOFF_MOST 1e30f
#define FAR          1e30f

/* ratio^(1/6) by Newton from above, without the C library's powers, whose bits hang on the CPU. */
static float sixth_root(float ratio)
{
    double root = fmax(1.0, (double)ratio);
    for (int i = 0; i < 64; i++) {
        const double fifth = root * root * root * root * root;
        root -= (root * fifth - (double)ratio) / (6.0 * fifth);
    }
    return (float)root;
}

static inline float clamp(float v, float least, float most)
{
    return v < least ? least : v > most ? most : v;
}

int32_t indirect_reach_px(float most_px)
{
    return (int32_t)ceilf(2.5f * most_px);
}

/* Narrower where it would look beyond the most that it may. */
static void fit_reach(struct indirect_rule *r)
{
    const float most = (float)(INDIRECT_REACH_MAX_PX - INDIRECT_NEAR_PX) - 2.0f;
    const float reach = 2.5f * (r->most_px + r->smooth_most_px);
    if (reach <= most) return;
    r->most_px *= most / reach;
    r->smooth_most_px *= most / reach;
    r->least_px = fminf(r->least_px, r->most_px);
    r->smooth_least_px = fminf(r->smooth_least_px, r->smooth_most_px);
}

struct indirect_rule indirect_rule_of(const struct plan *plan)
{
    const float lines = (float)plan->height_px / LINES;
    const float n = (float)plan->indirect_strata_per_axis * (float)plan->indirect_strata_per_axis;
    const float root = sixth_root(fmaxf(n, 1.0f) / SAMPLES); /* (n / 16)^(1/6) */
    struct indirect_rule r = {0};
    float base = 0.0f, cap = 0.0f;
    if (plan->indirect_filter == INDIRECT_FILTER_NONE) return r;
    switch (plan->indirect_filter) {
    case INDIRECT_FILTER_CONSTANT:
    case INDIRECT_FILTER_SHEARED: /* of what it does not shear: occlusion */
        base = 1.2f * root * root;
        cap = 7.5f / root;
        break;
    case INDIRECT_FILTER_LINEAR:
        base = 0.9f * root * root;
        cap = 7.0f / root;
        break;
    default:
        base = 1.0f;
        cap = 12.0f;
        r.smooth_least_px = 3.0f * lines;
        r.smooth_most_px = 6.0f * lines;
        break;
    }
    r.bandwidth = base / plan->mu;
    r.least_px = BETA_LEAST * plan->mu;
    r.most_px = fmaxf(cap * lines, BETA_LEAST) * plan->mu;
    r.near_px = 8.0f * lines;
    r.off_px = 2.0f * lines;
    fit_reach(&r);
    return r;
}

void indirect_widths(const struct indirect_rule *rule, const struct indirect_kernels *kernels,
                     const struct indirect_place *place, struct rect rect, float *beta)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const struct indirect_run run = indirect_place_run(place, rect, y, false, INDIRECT_NEAR_PX);
        const float *pixel = place->pixel + run.first;
        float *out = beta + run.first;
        kernels->nearness(&place->field, &run, place->nearness, beta);
        for (uint32_t i = 0; i < run.count; i++) {
            const float met = out[i] > 0.0f ? BANDLIMIT / out[i] : FAR;
            const float least = BANDLIMIT * rule->near_px * pixel[i];
            const float free = (met > least ? met : least) / rule->bandwidth;
            out[i] = clamp(free, rule->least_px * pixel[i], rule->most_px * pixel[i]);
        }
    }
}

void indirect_set_widths(const struct indirect_rule *rule, struct indirect_place *place,
                         struct rect rect, const float *beta, float scale)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = indirect_place_index(place, rect.x0, y);
        const float *pixel = place->pixel + first, *width = beta + first;
        float *falloff = place->falloff + first, *off = place->off + first;
        for (size_t i = 0; i < (size_t)rect_width(rect); i++) {
            const float b = width[i] * scale, inverse = b > 0.0f ? 0.5f / b / b : 0.0f;
            falloff[i] = inverse < FALLOFF_MOST ? inverse : FALLOFF_MOST;
            off[i] = 0.5f * b + rule->off_px * pixel[i];
        }
    }
}
