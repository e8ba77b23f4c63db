#include "server/reconstruct/glossy/glossy_pass.h"

#include <math.h>

#include "proto/half_field.h"
#include "server/reconstruct/indirect/indirect_width.h"

#define LINES        512.0f /* what the cap is counted at */
#define SAMPLES      16.0f
#define UNBOUND      1e30f
#define RULES        61   /* that are kept at a time */
#define SMOOTH_REACH 2.5f /* widths */

/* Squared errors vary less than light does: lobes may differ, if they are of one surface. */
#define SMOOTH_PX         8.0f
#define SMOOTH_MIN_PX     4.0f
#define SMOOTH_MAX_PX     12.0f
#define SMOOTH_SIMILARITY 0.1f

/* What rules of a filter are made of, at SAMPLES and LINES. */
struct shape {
    float width; /* of the lobe's own blur */
    float cap_px, footprint_px;
    float taper;
    float reach; /* caps */
};

/* Each is the best for its filters. Weights as published are not tapered; tapered ones keep more of
 * what lobes show at as little noise. Where a lobe's blur is s pixels wide and the filter w, bias
 * grows as w^2 / s^2 and noise falls as 1 / w, so that s^(2/3) is the best w. */
static const struct shape virtual_hits = {0.433f, 5.77f, 0.8f, 0.4f, 2.0f};
static const struct shape published = {0.42f, 5.0f, 0.0f, 0.0f, 2.5f};

static struct glossy_rule filter_rule(const struct plan *plan, float n, float width)
{
    const bool as_published = glossy_is_published(plan->glossy_filter);
    const struct shape *s = as_published ? &published : &virtual_hits;
    const float lines = (float)plan->height_px / LINES;
    const float less = as_published ? 1.0f : indirect_root(lines, 3);
    const float sixth = indirect_root(n / SAMPLES, 6), tenth = indirect_root(n / SAMPLES, 10);
    const float wide = width * s->width * plan->mu / (tenth * tenth * tenth * less);
    const float asked = s->cap_px * plan->mu / sixth * lines / less;
    const float cap = width * fminf(asked, GLOSSY_REACH_MAX_PX / s->reach);
    const float footprint = width * s->footprint_px * plan->mu / sixth;
    return (struct glossy_rule){
        .similarity = 2.0f / (wide * wide),
        .distance = 0.5f / (cap * cap),
        .footprint = as_published ? UNBOUND : 0.5f / (footprint * footprint),
        .taper = s->taper,
        .reach = (int32_t)ceilf(s->reach * cap),
    };
}

static struct glossy_rule smooth_rule(const struct plan *plan)
{
    const float asked = SMOOTH_PX * (float)plan->height_px / LINES;
    const float px = fminf(fmaxf(asked, SMOOTH_MIN_PX), SMOOTH_MAX_PX);
    return (struct glossy_rule){
        .similarity = SMOOTH_SIMILARITY,
        .distance = 0.5f / (px * px),
        .footprint = 0.5f / (px * px),
        .reach = (int32_t)ceilf(SMOOTH_REACH * px),
    };
}

static struct glossy_rule rule_of(const struct glossy_pass *pass, float n)
{
    return pass->smooth ? smooth_rule(pass->plan) : filter_rule(pass->plan, n, pass->width);
}

/* Rays that every pixel has. */
static float least_rays(const struct plan *plan)
{
    return fmaxf(half_field_rays(plan), 1.0f);
}

int32_t glossy_pass_reach(const struct glossy_pass *pass)
{
    return rule_of(pass, least_rays(pass->plan)).reach;
}

/* Each pixel's rule by its own rays, of which there are few different numbers. */
static void set_rules(const struct glossy_pass *pass, struct glossy_neighbourhood *around)
{
    const float *rays = pass->patch->glossy_rays, least = least_rays(pass->plan);
    struct glossy_rule known[RULES] = {{0}};
    float of[RULES] = {0};
    for (int32_t y = around->rect.y0; y < around->rect.y1; y++) {
        const size_t to = glossy_neighbourhood_index(around, around->rect.x0, y);
        const size_t from = patch_pixel(pass->patch, around->rect.x0, y);
        for (size_t i = 0; i < (size_t)rect_width(around->rect); i++) {
            const float n = fmaxf(rays[from + i], least);
            const uint32_t k = (uint32_t)n % RULES;
            if (of[k] != n) known[k] = rule_of(pass, of[k] = n);
            glossy_neighbourhood_rule(around, to + i, &known[k]);
        }
    }
}

static void run_rows(const struct glossy_neighbourhood *around, const struct glossy_rule *rule,
                     struct rect rect, bool along_x, uint32_t count, float *const *in,
                     float *const *out)
{
    const struct glossy_kernels *kernels = KERNELS_BEST(glossy_kernels);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const struct glossy_run run =
            glossy_neighbourhood_run(around, rect, y, along_x, rule->reach);
        kernels->spread[around->shape](&around->field, rule, &run, count, (const float *const *)in,
                                       out);
    }
}

void glossy_pass_run(const struct glossy_pass *pass, struct glossy_neighbourhood *around,
                     struct rect rect, uint32_t count, float *const *in, float *const *between,
                     float *const *out)
{
    const struct glossy_rule rule = rule_of(pass, least_rays(pass->plan));
    struct rect tall = rect;
    tall.y0 -= rule.reach;
    tall.y1 += rule.reach;
    glossy_neighbourhood_one_rule(around);
    if (pass->patch->glossy_rays && !pass->smooth) set_rules(pass, around);
    run_rows(around, &rule, rect_intersect(tall, around->rect), true, count, in, between);
    run_rows(around, &rule, rect, false, count, between, out);
}
