#include "server/reconstruct/glossy_pass.h"

#include <math.h>

#include "server/reconstruct/indirect_width.h"

#define LINES        512.0f /* what the cap is counted at */
#define SAMPLES      16.0f
#define WIDTH        0.42f /* of the lobe's own blur, at SAMPLES */
#define CAP_PX       5.0f
#define REACH        2.5f /* caps */
#define FOOTPRINT_PX 0.7f /* at SAMPLES */

/* Squared errors vary less than light does: lobes may differ, if they are of one surface. */
#define SMOOTH_PX       8.0f
#define SMOOTH_LEAST_PX 4.0f
#define SMOOTH_MOST_PX  12.0f
#define SMOOTH_LIKENESS 0.1f

static struct glossy_rule filter_rule(const struct plan *plan, float n, float width)
{
    const float sixth = indirect_root(n / SAMPLES, 6), tenth = indirect_root(n / SAMPLES, 10);
    const float wide = width * WIDTH * plan->mu / (tenth * tenth * tenth);
    const float asked = CAP_PX * plan->mu / sixth * (float)plan->height_px / LINES;
    const float cap = width * fminf(asked, GLOSSY_REACH_MAX_PX / REACH);
    const float footprint = width * FOOTPRINT_PX * plan->mu / sixth;
    return (struct glossy_rule){
        .likeness = 2.0f / (wide * wide),
        .distance = 0.5f / (cap * cap),
        .footprint = 0.5f / (footprint * footprint),
        .reach = (int32_t)ceilf(REACH * cap),
    };
}

static struct glossy_rule smooth_rule(const struct plan *plan)
{
    const float asked = SMOOTH_PX * (float)plan->height_px / LINES;
    const float px = fminf(fmaxf(asked, SMOOTH_LEAST_PX), SMOOTH_MOST_PX);
    return (struct glossy_rule){
        .likeness = SMOOTH_LIKENESS,
        .distance = 0.5f / (px * px),
        .footprint = 0.5f / (px * px),
        .reach = (int32_t)ceilf(REACH * px),
    };
}

static struct glossy_rule rule_of(const struct glossy_pass *pass, float n)
{
    return pass->smooth ? smooth_rule(pass->plan) : filter_rule(pass->plan, n, pass->width);
}

static float first_rays(const struct plan *plan)
{
    const float l = (float)plan->indirect_strata_per_axis;
    return fmaxf(l * l, 1.0f);
}

/* Under a target, as many as bounce rays. */
float *glossy_rays(const struct plan *plan, const struct patch *patch)
{
    return plan->target_error > 0.0f ? patch->bounces : NULL;
}

int32_t glossy_pass_reach(const struct glossy_pass *pass)
{
    return rule_of(pass, first_rays(pass->plan)).reach;
}

/* How many pixels from (x, y) on, up to x1, have as many rays as that one has, `*rays`. */
static int32_t alike(const struct glossy_pass *pass, int32_t x, int32_t x1, int32_t y, float *rays)
{
    const float *counts = glossy_rays(pass->plan, pass->patch);
    *rays = first_rays(pass->plan);
    if (!counts || pass->smooth) return x1 - x;
    const size_t first = patch_pixel(pass->patch, x, y);
    int32_t n = 1;
    while (x + n < x1 && counts[first + (size_t)n] == counts[first]) n++;
    *rays = fmaxf(counts[first], *rays);
    return n;
}

/* Row y of `rect`, from left to right: runs pass their ends, and the next ones set that right. */
static void run_row(const struct glossy_pass *pass, const struct glossy_place *place,
                    struct rect rect, int32_t y, bool along_x, uint32_t count, float *const *in,
                    float *const *out)
{
    const struct glossy_kernels *kernels = glossy_kernels_best();
    float before = 0.0f, rays;
    struct glossy_rule rule;
    for (int32_t x = rect.x0, n; x < rect.x1; x += n) {
        n = alike(pass, x, rect.x1, y, &rays);
        if (rays != before) rule = rule_of(pass, before = rays);
        const struct rect part = {x, y, x + n, y + 1};
        const struct glossy_run run = glossy_place_run(place, part, y, along_x, rule.reach);
        kernels->spread(&place->field, &rule, &run, count, (const float *const *)in, out);
    }
}

void glossy_pass_run(const struct glossy_pass *pass, const struct glossy_place *place,
                     struct rect rect, uint32_t count, float *const *in, float *const *between,
                     float *const *out)
{
    const int32_t reach = glossy_pass_reach(pass);
    struct rect tall = rect;
    tall.y0 -= reach;
    tall.y1 += reach;
    tall = rect_intersect(tall, place->rect);
    for (int32_t y = tall.y0; y < tall.y1; y++)
        run_row(pass, place, tall, y, true, count, in, between);
    for (int32_t y = rect.y0; y < rect.y1; y++)
        run_row(pass, place, rect, y, false, count, between, out);
}
