#include "server/reconstruct/glossy/glossy.h"

#include "server/reconstruct/glossy/glossy_bandlimit.h"
#include "server/reconstruct/glossy/glossy_variance.h"

#define WEIGHT_MIN 1e-6f
#define SQUARE_MAX 1e36f /* so that sums stay finite */

/* One call. */
struct glossy {
    const struct plan *plan;
    const struct patch *patch;
    struct rect inner;
    float *const *out;
    float *const *variance; /* NULL: not wanted */
};

static struct glossy_pass filter_pass(const struct plan *plan, const struct patch *patch)
{
    return (struct glossy_pass){.plan = plan, .patch = patch, .width = 1.0f};
}

/* Whether the filter compares the lobes of pixels. */
static bool compares(uint32_t filter)
{
    return filter == GLOSSY_FILTER_VIRTUAL_HIT || glossy_is_published(filter);
}

static int32_t filter_reach(const struct plan *plan)
{
    const struct glossy_pass pass = filter_pass(plan, NULL);
    return compares(plan->glossy_filter) ? glossy_pass_reach(&pass) : 0;
}

int32_t glossy_halo_px(const struct plan *plan)
{
    const int32_t beyond = patch_knows_glossy_errors(plan) ? glossy_variance_reach(plan) : 0;
    if (plan->glossy_filter == GLOSSY_FILTER_BANDLIMIT) return glossy_bandlimit_halo_px(plan);
    return filter_reach(plan) + beyond;
}

static bool can_filter(const struct glossy *g)
{
    const struct plan *plan = g->plan;
    const struct patch *p = g->patch;
    const struct rect inner = g->inner;
    const bool whole =
        !rect_is_empty(inner) && rect_area(rect_intersect(inner, p->rect)) == rect_area(inner);
    const bool surfaces = p->depth && p->normal[0] && p->id;
    const bool lobes = p->glossy[0] && p->glossy_alpha && p->glossy_nearness;
    if (g->variance && !patch_knows_glossy_errors(plan)) return false;
    return whole && lobes && (surfaces || plan->glossy_filter == GLOSSY_FILTER_NONE) &&
           plan->glossy_filter <= GLOSSY_FILTER_LAST;
}

/* Copies a measured pixel unfiltered, with the squared difference of its half as the variance. */
static void copy_pixel(const struct glossy *g, size_t i)
{
    const struct patch *p = g->patch;
    const bool glossy = patch_is_glossy(p, i);
    for (int c = 0; c < 3; c++) {
        g->out[c][i] = glossy ? p->glossy[c][i] : 0.0f;
        if (!g->variance) continue;
        const float off = glossy ? p->glossy_half[c][i] - p->glossy[c][i] : 0.0f;
        g->variance[c][i] = off * off < SQUARE_MAX ? off * off : SQUARE_MAX;
    }
}

static void copy(const struct glossy *g)
{
    for (int32_t y = g->inner.y0; y < g->inner.y1; y++) {
        const size_t first = patch_pixel(g->patch, g->inner.x0, y);
        for (size_t i = 0; i < (size_t)rect_width(g->inner); i++) copy_pixel(g, first + i);
    }
}

/* Light over weights. Lobes that took no part keep what was measured, as it is. Returns the pixels
 * that were filtered. */
static uint64_t store(const struct glossy *g, const struct glossy_neighbourhood *around,
                      float *const *channel)
{
    uint64_t filtered = 0;
    for (int32_t y = g->inner.y0; y < g->inner.y1; y++) {
        const size_t from = glossy_neighbourhood_index(around, g->inner.x0, y);
        const size_t to = patch_pixel(g->patch, g->inner.x0, y);
        for (size_t i = 0; i < (size_t)rect_width(g->inner); i++) {
            const float weight = channel[3][from + i];
            if (!around->object[from + i] || !(weight >= WEIGHT_MIN)) continue;
            for (int c = 0; c < 3; c++) g->out[c][to + i] = channel[c][from + i] / weight;
            filtered++;
        }
    }
    return filtered;
}

/* A filter that compares lobes, and what is known of errors with and without it. */
static int run(const struct glossy *g, uint64_t *filtered)
{
    const bool filters = compares(g->plan->glossy_filter);
    const struct glossy_pass pass = filter_pass(g->plan, g->patch);
    const int32_t reach = filter_reach(g->plan);
    const int32_t beyond = g->variance ? glossy_variance_reach(g->plan) : 0;
    const struct rect seen = rect_intersect(rect_grow(g->inner, reach + beyond), g->patch->rect);
    const struct rect wide = rect_intersect(rect_grow(g->inner, beyond), seen);
    struct glossy_neighbourhood p;
    const int error = glossy_neighbourhood_create(
        g->plan, g->patch, seen, reach > beyond ? reach : beyond, g->variance != NULL, &p);
    if (error) return error;
    float *const *out = g->variance ? p.wide : p.channel;
    if (filters) glossy_pass_run(&pass, &p, wide, p.channels, p.channel, p.between, out);
    if (filters) *filtered = store(g, &p, out);
    const struct glossy_variance variance = {g->plan, g->patch, &p, filters};
    if (g->variance) glossy_variance_find(&variance, wide, g->inner, g->variance);
    glossy_neighbourhood_fini(&p);
    return 0;
}

static int filter(const struct glossy *g, struct glossy_statistics *statistics)
{
    uint64_t filtered = 0;
    int error = 0;
    if (!can_filter(g)) return ERR_RANGE;
    const uint64_t lobes = patch_count_glossy(g->patch, g->inner);
    const uint32_t which = g->plan->glossy_filter;
    copy(g);
    if (lobes > 0 && which == GLOSSY_FILTER_BANDLIMIT)
        error = glossy_bandlimit(g->plan, g->patch, g->inner, g->out, g->variance, &filtered);
    else if (lobes > 0 && (compares(which) || g->variance))
        error = run(g, &filtered);
    if (error) return error;
    statistics->pixels_filtered += filtered;
    statistics->pixels_skipped += (uint64_t)rect_area(g->inner) - filtered;
    statistics->blocks_skipped += lobes == 0 ? 1 : 0;
    return 0;
}

int glossy_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                  float *const out[3], struct glossy_statistics *statistics)
{
    const struct glossy g = {plan, patch, inner, out, NULL};
    return filter(&g, statistics);
}

int glossy_filter_with_error(const struct plan *plan, const struct patch *patch, struct rect inner,
                             float *const out[3], float *const variance[3],
                             struct glossy_statistics *statistics)
{
    const struct glossy g = {plan, patch, inner, out, variance};
    return filter(&g, statistics);
}
