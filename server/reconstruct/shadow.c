#include "server/reconstruct/shadow.h"

#include <math.h>

#include "server/reconstruct/axis_aligned.h"
#include "server/reconstruct/edge.h"
#include "server/reconstruct/sheared.h"
#include "server/reconstruct/strata.h"

/* Of the light below the horizon, as receiver_sunk has it. For the sheared filter what is there
 * counts as seen, and for as much as the rest: where that is so much or more, the axis-aligned one
 * is asked instead, whose values have each stratum count for what it sends. */
#define SUNK_MOST 0.25f

/* One light over one block. `seen` and `width` of inner pixels, row by row. */
struct shadow {
    const struct plan *plan;
    const struct patch *patch;
    const struct shadow_kernels *kernels;
    struct receiver_light light;
    struct rect inner;
    float *seen;       /* -1: the pixel's own value stands */
    float *width;      /* pixels; 0: not filtered */
    float *unoccluded; /* E without occlusion */
    float *sunk; /* how much of the axis-aligned filter's answer there is in the sheared one's */
};

static int32_t reach_px(uint32_t filter)
{
    return filter == SHADOW_FILTER_SHEARED ? SHEARED_REACH_PX : AXIS_ALIGNED_REACH_PX;
}

int32_t shadow_halo_px(enum shadow_filter filter)
{
    return filter == SHADOW_FILTER_NONE ? 0 : reach_px(filter) + WEDGE_FILL_PX;
}

static size_t inner_index(const struct shadow *s, int32_t x, int32_t y)
{
    return (size_t)(y - s->inner.y0) * (size_t)rect_width(s->inner) + (size_t)(x - s->inner.x0);
}

static size_t receiver_index(const struct receivers *r, int32_t x, int32_t y)
{
    return (size_t)(y - r->rect.y0) * (size_t)rect_width(r->rect) + (size_t)(x - r->rect.x0);
}

/* E without occlusion of all inner pixels, and how far the light has sunk. */
static void fill_unoccluded(const struct shadow *s)
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
                                   s->unoccluded + inner_index(s, x, y));
            float *sunk = s->sunk + inner_index(s, x, y);
            receiver_sunk(&s->light, p, n, count, sunk);
            for (uint32_t i = 0; i < count; i++)
                sunk[i] = sunk[i] < SUNK_MOST ? sunk[i] / SUNK_MOST : 1.0f;
        }
    }
}

/* The first of `count` pixels from `first` on that an occluded sample shades, and one past the
 * last; `count` and 0 where there is none. */
static void shaded_span(const struct shadow *s, size_t first, int32_t count, int32_t *x0,
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
static struct rect shaded_rect(const struct shadow *s)
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

/* Pixels of `rect` that have a wedge, as indices of the receivers' rect; there is room for one
 * more. */
static uint32_t list_wedges(const struct receivers *r, const struct wedges *wedges,
                            struct rect rect, uint32_t *pixels)
{
    uint32_t count = 0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t row = receiver_index(r, rect.x0, y);
        for (size_t i = row; i < row + (size_t)rect_width(rect); i++) {
            pixels[count] = (uint32_t)i;
            count += wedges->most[i] >= 0.0f;
        }
    }
    return count;
}

/* Where `inner` has a pixel of the receivers' rect. */
static size_t index_of(const struct shadow *s, const struct receivers *r, uint32_t pixel)
{
    const uint32_t row = (uint32_t)rect_width(r->rect);
    return inner_index(s, r->rect.x0 + (int32_t)(pixel % row), r->rect.y0 + (int32_t)(pixel / row));
}

static void store(const struct shadow *s, const struct receivers *r, uint32_t pixel, float seen,
                  float width)
{
    const size_t to = index_of(s, r, pixel);
    s->seen[to] = seen;
    s->width[to] = width;
}

/* Pixels of which something is left for the sheared filter, into `rest`. */
static uint32_t list_rest(const struct edge_answer *edges, const uint32_t *pixels, uint32_t count,
                          uint32_t *rest)
{
    uint32_t left = 0;
    for (uint32_t k = 0; k < count; k++) {
        rest[left] = pixels[k];
        left += edges[k].kept > 0.0f;
    }
    return left;
}

/* What edges tell, then the rest sheared: rest and seen have room for `count` pixels. */
static int run_both(const struct shadow *s, struct receivers *r, const struct coverage *coverage,
                    const uint32_t *pixels, uint32_t count, struct edge_answer *edges,
                    uint32_t *rest, float *seen)
{
    int error = edges_filter(&s->light, s->patch, s->kernels, r, pixels, count, edges);
    if (error) return error;
    const uint32_t left = list_rest(edges, pixels, count, rest);
    error = sheared_filter(&s->light, s->patch, coverage, s->kernels, r, rest, left, seen);
    for (uint32_t k = 0, at = 0; !error && k < count; k++) {
        const float sheared = edges[k].kept > 0.0f ? seen[at++] : -1.0f;
        store(s, r, pixels[k], edge_join(&edges[k], sheared), edges[k].width_px);
    }
    return error;
}

static int run_sheared(const struct shadow *s, struct receivers *r, const struct wedges *wedges,
                       const uint32_t *pixels, uint32_t count)
{
    struct coverage coverage;
    struct scratch *scratch = s->patch->scratch;
    const float rho_most =
        wedge_scale(s->plan, s->light.strata) * s->light.sigma_y[0] / s->light.rectangle.half[0];
    float *seen = scratch_take(scratch, count * sizeof *seen);
    uint32_t *rest = scratch_take(scratch, count * sizeof *rest);
    struct edge_answer *edges = scratch_take(scratch, count * sizeof *edges);
    int error = coverage_create(s->light.strata, s->light.rectangle.profile, rho_most, &coverage);
    if (!seen || !rest || !edges) error = ERR_MEMORY;
    if (!error) error = wedges_shear(&s->light, wedges, s->kernels, &coverage, r);
    if (!error) error = run_both(s, r, &coverage, pixels, count, edges, rest, seen);
    coverage_fini(&coverage);
    scratch_give(scratch, edges);
    scratch_give(scratch, rest);
    scratch_give(scratch, seen);
    return error;
}

static int run_axis_aligned(const struct shadow *s, const struct receivers *r,
                            const struct wedges *wedges, struct rect shaded, const uint32_t *pixels,
                            uint32_t count)
{
    float *seen = scratch_take(s->patch->scratch, 2 * count * sizeof *seen);
    if (!seen) return ERR_MEMORY;
    float *width = seen + count;
    const int error = axis_aligned_filter(&s->light, s->patch, wedges, s->kernels, r, shaded,
                                          pixels, count, seen, width);
    for (uint32_t k = 0; !error && k < count; k++) store(s, r, pixels[k], seen[k], width[k]);
    scratch_give(s->patch->scratch, seen);
    return error;
}

/* Those of the pixels that the sheared filter answered for and whose light has sunk, into `out`,
 * and the smallest rectangle around them. */
static uint32_t list_sunk(const struct shadow *s, const struct receivers *r, const uint32_t *pixels,
                          uint32_t count, uint32_t *out, struct rect *around)
{
    const uint32_t row = (uint32_t)rect_width(r->rect);
    uint32_t n = 0;
    *around = (struct rect){INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN};
    for (uint32_t k = 0; k < count; k++) {
        const size_t i = index_of(s, r, pixels[k]);
        const int32_t x = r->rect.x0 + (int32_t)(pixels[k] % row);
        const int32_t y = r->rect.y0 + (int32_t)(pixels[k] / row);
        if (!(s->sunk[i] > 0.0f && s->unoccluded[i] > 0.0f && s->seen[i] >= 0.0f)) continue;
        *around = (struct rect){x < around->x0 ? x : around->x0, y < around->y0 ? y : around->y0,
                                x >= around->x1 ? x + 1 : around->x1, y + 1};
        out[n++] = pixels[k];
    }
    return n;
}

/* After the sheared filter. */
static int run_sunk(const struct shadow *s, const struct receivers *r, const struct wedges *wedges,
                    const uint32_t *pixels, uint32_t count)
{
    struct rect around;
    uint32_t *sunk = scratch_take(s->patch->scratch, count * sizeof *sunk);
    float *seen = scratch_take(s->patch->scratch, 2 * count * sizeof *seen);
    int error = sunk && seen ? 0 : ERR_MEMORY;
    const uint32_t n = error ? 0 : list_sunk(s, r, pixels, count, sunk, &around);
    if (n > 0)
        error = axis_aligned_filter(&s->light, s->patch, wedges, s->kernels, r, around, sunk, n,
                                    seen, seen + count);
    for (uint32_t k = 0; !error && k < n; k++) {
        const size_t to = index_of(s, r, sunk[k]);
        const float share = s->sunk[to], width = seen[count + k];
        s->seen[to] = share < 1.0f ? s->seen[to] + share * (seen[k] - s->seen[to]) : seen[k];
        s->width[to] = share < 1.0f ? s->width[to] + share * (width - s->width[to]) : width;
    }
    scratch_give(s->patch->scratch, seen);
    scratch_give(s->patch->scratch, sunk);
    return error;
}

/* Filters all that has a wedge in `shaded`. */
static int run_filter(const struct shadow *s, struct rect shaded)
{
    const uint32_t filter = s->plan->shadow_filter;
    struct receivers receivers;
    struct wedges wedges = {0};
    uint32_t *pixels =
        scratch_take(s->patch->scratch, ((size_t)rect_area(shaded) + 1) * sizeof *pixels);
    uint32_t count = 0;
    int error = receivers_create(&s->light, s->patch, s->kernels,
                                 rect_grow(shaded, reach_px(filter) + WEDGE_FILL_PX), &receivers);
    if (!pixels) error = ERR_MEMORY;
    if (!error) error = wedges_create(&s->light, s->patch, &receivers, s->kernels, &wedges);
    if (!error) count = list_wedges(&receivers, &wedges, shaded, pixels);
    if (count > 0)
        error = filter == SHADOW_FILTER_SHEARED
                    ? run_sheared(s, &receivers, &wedges, pixels, count)
                    : run_axis_aligned(s, &receivers, &wedges, shaded, pixels, count);
    if (count > 0 && !error && filter == SHADOW_FILTER_SHEARED)
        error = run_sunk(s, &receivers, &wedges, pixels, count);
    wedges_fini(&wedges);
    receivers_fini(&receivers);
    scratch_give(s->patch->scratch, pixels);
    return error;
}

/* Pixels that no filter answered for get their own estimates. */
static void fill_alone(const struct shadow *s, int32_t x, int32_t y, uint32_t count)
{
    const size_t from = inner_index(s, x, y);
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

static void compose_run(const struct shadow *s, int32_t x, int32_t y, uint32_t count,
                        float *irradiance, float *width_px, struct shadow_statistics *statistics)
{
    const size_t from = inner_index(s, x, y), to = patch_pixel(s->patch, x, y);
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

static void compose(const struct shadow *s, float *irradiance, float *width_px,
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
    struct shadow s = {
        .plan = plan, .patch = patch, .kernels = shadow_kernels_best(), .inner = inner};
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
        error = run_filter(&s, shaded);
    if (!error) compose(&s, irradiance, width_px, statistics);
    scratch_give(patch->scratch, memory);
    return error;
}
