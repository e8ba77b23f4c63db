#include "server/reconstruct/glossy.h"

#include <math.h>

#include "server/reconstruct/glossy_bandlimit.h"
#include "server/reconstruct/glossy_field.h"
#include "server/reconstruct/indirect_width.h"

#define LINES        512.0f /* what the cap is counted at */
#define SAMPLES      16.0f
#define WIDTH        0.42f /* of the lobe's own blur, at SAMPLES */
#define CAP_PX       5.0f
#define REACH        2.5f /* caps */
#define FOOTPRINT_PX 0.7f /* at SAMPLES */
#define WEIGHT_LEAST 1e-6f
#define RULES        61 /* that are kept at a time */

/* Of pixels with n rays. */
static struct glossy_rule rule_of(const struct plan *plan, float n)
{
    const float sixth = indirect_root(n / SAMPLES, 6), tenth = indirect_root(n / SAMPLES, 10);
    const float wide = WIDTH * plan->mu / (tenth * tenth * tenth);
    const float asked = CAP_PX * plan->mu / sixth * (float)plan->height_px / LINES;
    const float cap = fminf(asked, GLOSSY_REACH_MAX_PX / REACH);
    const float footprint = FOOTPRINT_PX * plan->mu / sixth;
    return (struct glossy_rule){
        .likeness = 2.0f / (wide * wide),
        .distance = 0.5f / (cap * cap),
        .footprint = 0.5f / (footprint * footprint),
        .reach = (int32_t)ceilf(REACH * cap),
    };
}

/* Rays that every pixel has. */
static float least_rays(const struct plan *plan)
{
    const float l = (float)plan->indirect_strata_per_axis;
    return fmaxf(l * l, 1.0f);
}

int32_t glossy_halo_px(const struct plan *plan)
{
    if (plan->glossy_filter == GLOSSY_FILTER_VIRTUAL_HIT)
        return rule_of(plan, least_rays(plan)).reach;
    return plan->glossy_filter == GLOSSY_FILTER_BANDLIMIT ? glossy_bandlimit_halo_px(plan) : 0;
}

static bool can_filter(const struct plan *plan, const struct patch *p, struct rect inner)
{
    const bool whole =
        !rect_is_empty(inner) && rect_area(rect_intersect(inner, p->rect)) == rect_area(inner);
    const bool surfaces = p->depth && p->normal[0] && p->id;
    const bool lobes = p->glossy[0] && p->glossy_alpha && p->glossy_nearness;
    return whole && lobes && (surfaces || plan->glossy_filter == GLOSSY_FILTER_NONE) &&
           plan->glossy_filter <= GLOSSY_FILTER_BANDLIMIT;
}

/* What was measured, as it is. */
static void copy(const struct patch *patch, struct rect inner, float *const out[3])
{
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        const size_t first = patch_pixel(patch, inner.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(inner); i++)
            for (int c = 0; c < 3; c++)
                out[c][i] = patch_is_glossy(patch, i) ? patch->glossy[c][i] : 0.0f;
    }
}

static void run_rows(const struct glossy_place *place, const struct glossy_rule *rule,
                     struct rect rect, bool along_x, float *const *in, float *const *out)
{
    const struct glossy_kernels *kernels = glossy_kernels_best();
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const struct glossy_run run = glossy_place_run(place, rect, y, along_x, rule->reach);
        kernels->spread(&place->field, rule, &run, GLOSSY_CHANNELS, (const float *const *)in, out);
    }
}

/* Light over weights. Lobes that took no part keep what was measured, as it is. Returns the pixels
 * that were filtered. */
static uint64_t store(const struct glossy_place *place, const struct patch *patch,
                      struct rect inner, float *const out[3])
{
    uint64_t filtered = 0;
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        const size_t from = glossy_place_index(place, inner.x0, y);
        const size_t to = patch_pixel(patch, inner.x0, y);
        for (size_t i = 0; i < (size_t)rect_width(inner); i++) {
            const float weight = place->channel[3][from + i];
            if (!place->object[from + i] || !(weight >= WEIGHT_LEAST)) continue;
            for (int c = 0; c < 3; c++) out[c][to + i] = place->channel[c][from + i] / weight;
            filtered++;
        }
    }
    return filtered;
}

/* Each pixel's rule by its own rays, of which there are few different numbers. */
static void set_rules(const struct plan *plan, const struct patch *patch,
                      struct glossy_place *place)
{
    struct glossy_rule known[RULES] = {{0}};
    float of[RULES] = {0};
    for (int32_t y = place->rect.y0; y < place->rect.y1; y++) {
        const size_t to = glossy_place_index(place, place->rect.x0, y);
        const size_t from = patch_pixel(patch, place->rect.x0, y);
        for (size_t i = 0; i < (size_t)rect_width(place->rect); i++) {
            const float n = fmaxf(patch->glossy_rays[from + i], least_rays(plan));
            const uint32_t k = (uint32_t)n % RULES;
            if (of[k] != n) known[k] = rule_of(plan, of[k] = n);
            glossy_place_rule(place, to + i, &known[k]);
        }
    }
}

static int run(const struct plan *plan, const struct patch *patch, struct rect inner,
               float *const out[3], uint64_t *filtered)
{
    const struct glossy_rule rule = rule_of(plan, least_rays(plan));
    const struct rect seen = rect_intersect(rect_grow(inner, rule.reach), patch->rect);
    struct glossy_place place;
    const int error = glossy_place_create(plan, patch, seen, rule.reach, &place);
    if (error) return error;
    if (patch->glossy_rays) set_rules(plan, patch, &place);
    struct rect tall = inner;
    tall.y0 -= rule.reach;
    tall.y1 += rule.reach;
    run_rows(&place, &rule, rect_intersect(tall, seen), true, place.channel, place.between);
    run_rows(&place, &rule, inner, false, place.between, place.channel);
    *filtered = store(&place, patch, inner, out);
    glossy_place_fini(&place);
    return 0;
}

int glossy_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                  float *const out[3], struct glossy_statistics *statistics)
{
    uint64_t filtered = 0;
    int error = 0;
    if (!can_filter(plan, patch, inner)) return ERR_RANGE;
    const uint64_t lobes = patch_count_glossy(patch, inner);
    copy(patch, inner, out);
    if (lobes > 0 && plan->glossy_filter == GLOSSY_FILTER_VIRTUAL_HIT)
        error = run(plan, patch, inner, out, &filtered);
    else if (lobes > 0 && plan->glossy_filter == GLOSSY_FILTER_BANDLIMIT)
        error = glossy_bandlimit(plan, patch, inner, out, &filtered);
    if (error) return error;
    statistics->pixels_filtered += filtered;
    statistics->pixels_skipped += (uint64_t)rect_area(inner) - filtered;
    statistics->blocks_skipped += lobes == 0 ? 1 : 0;
    return 0;
}
