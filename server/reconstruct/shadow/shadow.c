#include "server/reconstruct/shadow/shadow.h"

#include "server/reconstruct/shadow/shadow_answer.h"
#include "server/reconstruct/shadow/strata.h"
#include "server/reconstruct/shadow/wedge.h"

/* The part of the light below the horizon (receiver_sunk) from which on the sheared filter's answer
 * has no weight (shadow_answer.h). */
#define SUNK_MAX 0.25f

int32_t shadow_halo_px(enum shadow_filter filter)
{
    return filter == SHADOW_FILTER_NONE ? 0 : shadow_reach_px(filter) + WEDGE_FILL_PX;
}

/* Computes E without occlusion for all inner pixels, and how far the light has sunk. */
static void fill_unoccluded(const struct shadow_block *s)
{
    float point[3][STRATA_RUN], normal[3][STRATA_RUN];
    float *const points[3] = {point[0], point[1], point[2]};
    float *const normals[3] = {normal[0], normal[1], normal[2]};
    const float *const p[3] = {point[0], point[1], point[2]};
    const float *const n[3] = {normal[0], normal[1], normal[2]};
    for (int32_t y = s->inner.y0; y < s->inner.y1; y++) {
        for (int32_t x = s->inner.x0; x < s->inner.x1; x += STRATA_RUN) {
            const int32_t left = s->inner.x1 - x;
            const uint32_t count = (uint32_t)(left < STRATA_RUN ? left : STRATA_RUN);
            receiver_row(&s->light, s->patch, x, y, count, points, normals);
            s->kernels->unoccluded(&s->light.rectangle, count, p, n,
                                   s->unoccluded + shadow_block_pixel(s, x, y));
            float *sunk = s->sunk + shadow_block_pixel(s, x, y);
            receiver_sunk(&s->light, p, n, count, sunk);
            for (uint32_t i = 0; i < count; i++)
                sunk[i] = sunk[i] < SUNK_MAX ? sunk[i] / SUNK_MAX : 1.0f;
        }
    }
}

/* The first of `count` pixels from `first` on that an occluded sample shades, and one past the
 * last; `count` and 0 where there is none. */
static void shaded_span(const struct shadow_block *s, size_t first, int32_t count, int32_t *x0,
                        int32_t *x1)
{
    const float *slope = s->patch->lights[s->light.index].slope_max + first;
    *x0 = 0;
    while (*x0 < count && !(slope[*x0] > 0.0f)) ++*x0;
    *x1 = *x0 < count ? count : 0;
    while (*x1 > 0 && !(slope[*x1 - 1] > 0.0f)) --*x1;
}

/* The smallest rectangle around inner pixels that an occluded sample is near enough to shade:
 * no other can have a wedge. Empty when there is none. */
static struct rect shaded_rect(const struct shadow_block *s)
{
    const struct rect look = rect_intersect(rect_grow(s->inner, WEDGE_FILL_PX), s->patch->rect);
    const int32_t width = rect_width(look);
    struct rect found = {INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN};
    for (int32_t y = look.y0; y < look.y1; y++) {
        int32_t x0, x1;
        shaded_span(s, patch_pixel(s->patch, look.x0, y), width, &x0, &x1);
        if (x1 == 0) continue;
        if (look.x0 + x0 < found.x0) found.x0 = look.x0 + x0;
        if (look.x0 + x1 > found.x1) found.x1 = look.x0 + x1;
        if (y < found.y0) found.y0 = y;
        found.y1 = y + 1;
    }
    if (found.x1 < found.x0) return (struct rect){0, 0, 0, 0};
    return rect_intersect(rect_grow(found, WEDGE_FILL_PX), s->inner);
}

/* Pixels that no filter answered for get their own estimates. */
static void fill_alone(const struct shadow_block *s, int32_t x, int32_t y, uint32_t count)
{
    const size_t from = shadow_block_pixel(s, x, y);
    float own[STRATA_RUN];
    bool any = false;
    for (size_t i = from; i < from + count; i++)
        any = any || (s->unoccluded[i] > 0.0f && s->seen[i] < 0.0f);
    if (!any) return;
    strata_estimate(&s->light, s->patch, s->kernels, x, y, count, own);
    for (uint32_t i = 0; i < count; i++) {
        if (!(s->seen[from + i] < 0.0f)) continue;
        s->seen[from + i] = own[i];
        s->width[from + i] = 0.0f;
    }
}

static void compose_run(const struct shadow_block *s, int32_t x, int32_t y, uint32_t count,
                        float *irradiance, float *width_px, struct shadow_statistics *statistics)
{
    const size_t from = shadow_block_pixel(s, x, y), to = patch_pixel(s->patch, x, y);
    for (uint32_t i = 0; i < count; i++) {
        const bool lit = s->unoccluded[from + i] > 0.0f;
        const bool filtered = lit && s->seen[from + i] >= 0.0f;
        statistics->pixels_unlit += lit ? 0 : 1;
        statistics->pixels_filtered += filtered ? 1 : 0;
        statistics->pixels_alone += lit && !filtered ? 1 : 0;
    }
    fill_alone(s, x, y, count);
    for (uint32_t i = 0; i < count; i++) {
        const float e = s->unoccluded[from + i];
        irradiance[to + i] = e > 0.0f ? e * s->seen[from + i] : 0.0f;
        if (width_px) width_px[to + i] = e > 0.0f ? s->width[from + i] : 0.0f;
    }
}

static void compose(const struct shadow_block *s, float *irradiance, float *width_px,
                    struct shadow_statistics *statistics)
{
    for (int32_t y = s->inner.y0; y < s->inner.y1; y++) {
        for (int32_t x = s->inner.x0; x < s->inner.x1; x += STRATA_RUN) {
            const int32_t left = s->inner.x1 - x;
            compose_run(s, x, y, (uint32_t)(left < STRATA_RUN ? left : STRATA_RUN), irradiance,
                        width_px, statistics);
        }
    }
}

static bool can_filter(const struct plan *plan, uint32_t light, const struct patch *patch,
                       struct rect inner)
{
    if (light >= plan->light_count || plan->lights[light].type != LIGHT_RECTANGLE) return false;
    const struct patch_light *p = &patch->lights[light];
    const bool planes = patch->depth && patch->normal[0] && p->visibility && p->slope_min;
    const struct rect common = rect_intersect(inner, patch->rect);
    const uint32_t l = plan->lights[light].strata_per_axis;
    return planes && !rect_is_empty(inner) && rect_area(common) == rect_area(inner) && l > 0 &&
           l <= SHADOW_STRATA_MAX;
}

int shadow_filter(const struct plan *plan, uint32_t light, const struct patch *patch,
                  struct rect inner, float *irradiance, float *width_px,
                  struct shadow_statistics *statistics)
{
    if (!can_filter(plan, light, patch, inner)) return ERR_RANGE;
    const size_t area = (size_t)rect_area(inner);
    struct shadow_block s = {
        .plan = plan, .patch = patch, .kernels = KERNELS_BEST(shadow_kernels), .inner = inner};
    float *memory = scratch_take(patch->scratch, 4 * area * sizeof *memory);
    int error = 0;
    if (!memory) return ERR_MEMORY;
    s.seen = memory;
    s.width = memory + area;
    s.unoccluded = memory + 2 * area;
    s.sunk = memory + 3 * area;
    for (size_t i = 0; i < area; i++) {
        s.seen[i] = -1.0f;
        s.width[i] = 0.0f;
    }
    receiver_light_init(&s.light, plan, light);
    fill_unoccluded(&s);
    struct rect shaded = {0, 0, 0, 0};
    if (plan->shadow_filter != SHADOW_FILTER_NONE) shaded = shaded_rect(&s);
    if (rect_is_empty(shaded))
        statistics->blocks_skipped++;
    else
        error = shadow_answer(&s, shaded);
    if (!error) compose(&s, irradiance, width_px, statistics);
    scratch_give(patch->scratch, memory);
    return error;
}
