#include "server/reconstruct/indirect/indirect_width.h"

#include <math.h>

#include "proto/half_field.h"
#include "proto/samples.h"
#include "server/reconstruct/indirect/indirect.h"
#include "server/reconstruct/indirect/indirect_adaptive.h"
#include "server/reconstruct/simd/clamp.h"

#define LINES       512.0f /* what pixels below are counted at */
#define SAMPLES     16.0f
#define BANDLIMIT   (2.0f / INDIRECT_OMEGA_LAMBERT)
#define BETA_MIN    0.6f
#define FALLOFF_MAX 1e30f
#define RATE_CAP_PX 7.5f /* at mu = 1, as rule A's at 16 samples */
#define FAR         1e30f

/* The blend's widths over those of rule B, and what smooths its decisions: the latter at most a
 * third of the reach, the widest what is left of it. */
#define BLEND_WIDEST  2.0f
#define BLEND_FINEST  0.5f
#define BLEND_SPREAD  1.2f /* widest over finest, at least */
#define SMOOTH_MIN    6.0f /* pixels, counted at LINES */
#define SMOOTH_MAX    12.0f
#define SMOOTH_ERRORS 4.0f /* pixels: squares of single ones tell little */

float indirect_root(float ratio, int degree)
{
    double root = fmax(1.0, (double)ratio);
    for (int i = 0; i < 64; i++) {
        double below = root; /* root^(degree - 1): at least about the ratio, never 0 */
        for (int k = 2; k < degree; k++) below *= root;
        root -= (root * below - (double)ratio) / (degree * below);
    }
    return (float)root;
}

int32_t indirect_reach_px(float most_px)
{
    return (int32_t)ceilf(2.5f * most_px);
}

/* Returns the reach in pixels of all steps that look at pixels around, one after the other. */
static float most_in_reach(void)
{
    return (float)(INDIRECT_REACH_MAX_PX - INDIRECT_NEAR_PX - 2) / 2.5f;
}

/* Squares of errors are smoothed as the blend's decisions are, without a filter, too; in what reach
 * the filter leaves, so that they do not change the picture. */
static void smooth_errors(const struct plan *plan, float lines, struct indirect_rule *r)
{
    const float left = fmaxf(most_in_reach() - r->most_px, 0.0f);
    if (!patch_knows_errors(plan) || plan->indirect_filter == INDIRECT_FILTER_BLEND) return;
    r->smooth_max_px = fminf(fmaxf(SMOOTH_MAX * lines, SMOOTH_ERRORS), left);
    r->smooth_min_px = fminf(fmaxf(SMOOTH_MIN * lines, SMOOTH_ERRORS), r->smooth_max_px);
}

/* Rule B's widths times `widest` and, three steps on, times `finest`. Where lines are so many that
 * the reach bounds the widest, all steps become smaller, and the finest stays. */
static void spread_widths(struct indirect_rule *r, float lines)
{
    const float all = most_in_reach();
    r->smooth_max_px = fminf(SMOOTH_MAX * lines, 0.25f * all);
    r->smooth_min_px = fminf(SMOOTH_MIN * lines, r->smooth_max_px);
    const float widest = fminf(BLEND_WIDEST, (all - r->smooth_max_px) / r->most_px);
    const float finest = fminf(BLEND_FINEST, widest / BLEND_SPREAD);
    const float spread = widest / finest;
    r->ratio = 1.0f / indirect_root(spread * spread, 6);
    r->bandwidth /= widest;
    r->most_px *= widest;
}

/* The paper's widths: as narrow as mu asks for, and no wider than rule A's cap, where n grows with
 * the square of mu. */
static void rate_widths(const struct plan *plan, float lines, struct indirect_rule *r)
{
    const float mu = indirect_adaptive_width_mu(plan->adaptive.mu);
    const float most = RATE_CAP_PX * lines / indirect_root(mu, 3);
    r->bandwidth = mu;
    r->least_px = 2.0f / INDIRECT_ADAPTIVE_WIDTH_ALPHA / mu;
    r->most_px = fminf(fmaxf(most, r->least_px), most_in_reach());
    r->least_px = fminf(r->least_px, r->most_px);
    r->near_px = INDIRECT_ADAPTIVE_NEAR_PX * lines;
    r->off_px = 2.0f * lines;
}

struct indirect_rule indirect_rule_of(const struct plan *plan)
{
    const float lines = (float)plan->height_px / LINES;
    const float n = half_field_rays(plan);
    const float root = indirect_root(fmaxf(n, 1.0f) / SAMPLES, 6); /* (n / 16)^(1/6) */
    struct indirect_rule r = {0};
    float base = 0.0f, cap = 0.0f;
    if (plan->indirect_filter == INDIRECT_FILTER_NONE) {
        smooth_errors(plan, lines, &r);
        return r;
    }
    if (plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE) {
        rate_widths(plan, lines, &r);
        return r;
    }
    switch (plan->indirect_filter) {
    case INDIRECT_FILTER_CONSTANT:
    case INDIRECT_FILTER_SHEARED: /* of what it does not shear: occlusion */
        base = 1.2f * root * root;
        cap = 7.5f / root;
        break;
    default: /* linear, and what the blend's widths are multiples of */
        base = 0.9f * root * root;
        cap = 7.0f / root;
        break;
    }
    r.samples = fmaxf(n, 1.0f);
    r.bandwidth = base / plan->mu;
    r.least_px = BETA_MIN * plan->mu;
    r.most_px = fmaxf(cap * lines, BETA_MIN) * plan->mu;
    r.near_px = 8.0f * lines;
    r.off_px = 2.0f * lines;
    r.most_px = fminf(r.most_px, most_in_reach());
    if (plan->indirect_filter == INDIRECT_FILTER_BLEND) spread_widths(&r, lines);
    r.least_px = fminf(r.least_px, r.most_px);
    smooth_errors(plan, lines, &r);
    return r;
}

/* mu(n) and cap(n) of a pixel with another n than the plan's. */
static void vary_rule(const struct indirect_rule *rule, float count, float *bandwidth,
                      float *most_px)
{
    const float root = indirect_root(fmaxf(count, 1.0f) / rule->samples, 6); /* ratio^(1/6) */
    *bandwidth = rule->bandwidth * root * root;
    *most_px = fmaxf(rule->most_px / root, rule->least_px);
}

void indirect_widths(const struct indirect_rule *rule, const struct indirect_kernels *kernels,
                     const struct indirect_neighbourhood *around, const float *counts,
                     struct rect rect, float *beta)
{
    const bool vary = counts && rule->samples > 0.0f;
    float bandwidth = rule->bandwidth, most = rule->most_px,
          of = rule->samples; /* of pixels before */
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const struct indirect_run run =
            indirect_neighbourhood_run(around, rect, y, false, INDIRECT_NEAR_PX);
        const float *pixel = around->pixel + run.first;
        float *out = beta + run.first;
        kernels->nearness(&around->field, &run, around->nearness, beta);
        for (uint32_t i = 0; i < run.count; i++) {
            const float met = out[i] > 0.0f ? BANDLIMIT / out[i] : FAR;
            const float least = BANDLIMIT * rule->near_px * pixel[i];
            if (vary && counts[run.first + i] != of)
                vary_rule(rule, of = counts[run.first + i], &bandwidth, &most);
            const float free = (met > least ? met : least) / bandwidth;
            out[i] = clamp(free, rule->least_px * pixel[i], most * pixel[i]);
        }
    }
}

void indirect_set_widths(const struct indirect_rule *rule, struct indirect_neighbourhood *around,
                         struct rect rect, const float *beta, float scale)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = indirect_neighbourhood_index(around, rect.x0, y);
        const float *pixel = around->pixel + first, *width = beta + first;
        float *falloff = around->falloff + first, *off = around->off + first;
        for (size_t i = 0; i < (size_t)rect_width(rect); i++) {
            const float b = width[i] * scale, inverse = b > 0.0f ? 0.5f / b / b : 0.0f;
            falloff[i] = inverse < FALLOFF_MAX ? inverse : FALLOFF_MAX;
            off[i] = 0.5f * b + rule->off_px * pixel[i];
        }
    }
}
