#include "server/reconstruct/indirect/indirect.h"

#include "proto/samples.h"
#include "server/reconstruct/indirect/indirect_blend.h"
#include "server/reconstruct/indirect/indirect_isolated.h"
#include "server/reconstruct/indirect/indirect_spikes.h"
#include "server/reconstruct/indirect/indirect_variance.h"

/* The radius of isolated pixels' windows, in the filter's largest widths. It is within the filter's
 * reach. */
#define ISOLATED_REACH 2.0f

/* One call: `count` channels over `inner`. */
struct indirect {
    const struct plan *plan;
    const struct patch *patch;
    struct rect inner;
    uint32_t count;
    const float *const *in;
    float *const *out;
    float *width_px;                    /* may be NULL */
    const struct indirect_error *error; /* may be NULL */
};

/* Channels that are filtered: halves come after the others. */
static uint32_t channels_of(const struct indirect *f)
{
    return f->error ? f->count + 3 : f->count;
}

static const float *channel_of(const struct indirect *f, uint32_t c)
{
    return c < f->count ? f->in[c] : f->error->half[c - f->count];
}

/* Returns whether spikes are spread: by the filters of one width, and where patches have not lens
 * samples in all of a larger halo. */
static bool has_spikes(const struct plan *plan)
{
    return (plan->indirect_filter == INDIRECT_FILTER_CONSTANT ||
            plan->indirect_filter == INDIRECT_FILTER_LINEAR) &&
           plan->lens_strata_per_axis == 0;
}

int32_t indirect_halo_px(const struct plan *plan)
{
    const struct indirect_rule r = indirect_rule_of(plan);
    if (!(r.most_px > 0.0f || r.smooth_max_px > 0.0f)) return 0;
    const int32_t filter = indirect_reach_px(r.most_px) + INDIRECT_NEAR_PX;
    const int32_t spikes = has_spikes(plan) ? indirect_spikes_reach(&r) : 0;
    return indirect_reach_px(r.smooth_max_px) + (filter > spikes ? filter : spikes);
}

static bool can_filter(const struct indirect *f)
{
    const struct patch *p = f->patch;
    const struct rect common = rect_intersect(f->inner, p->rect);
    const bool known = f->plan->indirect_filter <= INDIRECT_FILTER_SHEARED;
    return known && p->depth && p->normal[0] && p->id && p->bounce_distance_min &&
           !rect_is_empty(f->inner) && rect_area(common) == rect_area(f->inner) &&
           channels_of(f) <= INDIRECT_CHANNELS_MAX;
}

/* Copies measured light unfiltered. */
static void copy(const struct indirect *f)
{
    for (int32_t y = f->inner.y0; y < f->inner.y1; y++) {
        const size_t first = patch_pixel(f->patch, f->inner.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(f->inner); i++) {
            const bool measured = patch_is_measured(f->patch, i);
            for (uint32_t c = 0; c < f->count; c++) f->out[c][i] = measured ? f->in[c][i] : 0.0f;
            if (f->width_px) f->width_px[i] = 0.0f;
            for (uint32_t c = 0; c < 3 && f->error; c++) f->error->variance[c][i] = 0.0f;
        }
    }
}

/* to[i] = where there is a pixel from[i] by it, 0 elsewhere. */
static void move_row(const float *pixel, size_t count, const float *from, float *to)
{
    for (size_t i = 0; i < count; i++) {
        const float value = from[i];
        to[i] = pixel[i] > 0.0f ? value : 0.0f;
    }
}

/* Loads a plane of the patch into an array of the neighbourhood. */
static void load_plane(const struct indirect *f, const struct indirect_neighbourhood *around,
                       const float *plane, float *out)
{
    const struct rect r = around->rect;
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t to = indirect_neighbourhood_index(around, r.x0, y);
        move_row(around->pixel + to, (size_t)rect_width(r), plane + patch_pixel(f->patch, r.x0, y),
                 out + to);
    }
}

/* Channel c into a spare of the neighbourhood. */
static void load(const struct indirect *f, const struct indirect_neighbourhood *around, uint32_t c,
                 uint32_t spare)
{
    load_plane(f, around, channel_of(f, c), indirect_neighbourhood_spare(around, spare));
}

static void store(const struct indirect *f, const struct indirect_neighbourhood *around,
                  const float *beta)
{
    const size_t count = (size_t)rect_width(f->inner);
    for (int32_t y = f->inner.y0; y < f->inner.y1; y++) {
        const size_t from = indirect_neighbourhood_index(around, f->inner.x0, y);
        const size_t to = patch_pixel(f->patch, f->inner.x0, y);
        const float *pixel = around->pixel + from;
        for (uint32_t c = 0; c < f->count; c++)
            move_row(pixel, count, indirect_neighbourhood_spare(around, c) + from, f->out[c] + to);
        for (size_t i = 0; f->width_px && i < count; i++)
            f->width_px[to + i] = pixel[i] > 0.0f ? beta[from + i] / pixel[i] : 0.0f;
    }
}

/* Rules A and B. Spares: the channels, beta, what is between the passes. */
static void run_rule(const struct indirect *f, const struct indirect_rule *rule,
                     const struct indirect_kernels *kernels, struct rect rect,
                     struct indirect_neighbourhood *around)
{
    const uint32_t count = channels_of(f);
    const struct indirect_pass pass = {
        .kernels = kernels,
        .lines = f->plan->indirect_filter == INDIRECT_FILTER_LINEAR,
        .reach = indirect_reach_px(rule->most_px),
        .count = count,
    };
    const struct rect tall = indirect_pass_tall(around, rect, pass.reach);
    float *channels[INDIRECT_CHANNELS_MAX], *between[INDIRECT_CHANNELS_MAX];
    float *beta = indirect_neighbourhood_spare(around, count);
    float *counts = f->patch->bounces ? indirect_neighbourhood_spare(around, count + 1) : NULL;
    for (uint32_t c = 0; c < count; c++) {
        channels[c] = indirect_neighbourhood_spare(around, c);
        between[c] = indirect_neighbourhood_spare(around, count + 1 + c);
    }
    if (counts) load_plane(f, around, f->patch->bounces, counts); /* before it is between */
    indirect_widths(rule, kernels, around, counts, tall, beta);
    indirect_set_widths(rule, around, tall, beta, 1.0f);
    indirect_pass_run(&pass, around, rect, (const float *const *)channels, between, channels);
}

/* Returns the number of spares that the filter itself needs; those of errors follow. */
static uint32_t filter_spares(const struct indirect *f)
{
    const uint32_t count = channels_of(f);
    return f->plan->indirect_filter == INDIRECT_FILTER_BLEND ? indirect_blend_spares(count)
                                                             : 2 * count + 1;
}

static void run_filter(const struct indirect *f, const struct indirect_rule *rule,
                       const struct indirect_kernels *kernels, struct rect rect,
                       struct indirect_neighbourhood *around)
{
    float *counts;
    switch (f->plan->indirect_filter) {
    case INDIRECT_FILTER_NONE:
        break;
    case INDIRECT_FILTER_BLEND:
        counts =
            f->patch->bounces ? indirect_neighbourhood_spare(around, filter_spares(f) - 1) : NULL;
        if (counts) load_plane(f, around, f->patch->bounces, counts);
        indirect_blend(rule, kernels, around, counts, rect, channels_of(f), f->count);
        break;
    default:
        run_rule(f, rule, kernels, rect, around);
        break;
    }
}

static void run_error(const struct indirect *f, const struct indirect_rule *rule,
                      const struct indirect_kernels *kernels, struct rect wide,
                      struct indirect_neighbourhood *around)
{
    const uint32_t count = channels_of(f), more = filter_spares(f);
    const bool blend = f->plan->indirect_filter == INDIRECT_FILTER_BLEND;
    struct indirect_variance s = {.plan = f->plan,
                                  .rule = rule,
                                  .kernels = kernels,
                                  .around = around,
                                  .mean = 0,
                                  .half = f->count,
                                  .width = count,
                                  .ratio = blend ? rule->ratio : 0.5f,
                                  .own = more + 6};
    for (uint32_t k = 0; k < 6; k++) {
        const uint32_t c = k < 3 ? k : f->count + k - 3;
        s.narrower[k] = blend ? indirect_blend_narrower(count, c) : more + k;
        if (!blend) load(f, around, c, s.narrower[k]);
    }
    indirect_variance_find(&s, wide, f->inner);
    for (int32_t y = f->inner.y0; y < f->inner.y1; y++) {
        const size_t from = indirect_neighbourhood_index(around, f->inner.x0, y);
        const size_t to = patch_pixel(f->patch, f->inner.x0, y);
        for (uint32_t c = 0; c < 3; c++)
            move_row(around->pixel + from, (size_t)rect_width(f->inner),
                     indirect_variance_of(&s, c) + from, f->error->variance[c] + to);
    }
}

/* Fills isolated pixels by means over windows. Only pictures through a lens need that, because lens
 * samples show the light of such a pixel as it is. Errors do not account for windows, so it does
 * not run with them. */
static void fill_isolated(const struct indirect *f, const struct indirect_rule *rule,
                          const struct indirect_neighbourhood *around, uint64_t *isolated)
{
    float *const out[3] = {indirect_neighbourhood_spare(around, 0),
                           indirect_neighbourhood_spare(around, 1),
                           indirect_neighbourhood_spare(around, 2)};
    const bool lens = f->plan->lens_relight != LENS_RELIGHT_OWN;
    if (!lens || f->error || f->count < 3 || f->patch->bounces) return;
    *isolated += indirect_isolated_fill(f->plan, f->patch, around, f->inner,
                                        (int32_t)(ISOLATED_REACH * rule->most_px), f->in, out);
}

/* Of the filter and of its errors; those of spikes follow. */
static uint32_t spares_of(const struct indirect *f)
{
    return filter_spares(f) + (f->error ? 6 + INDIRECT_VARIANCE_SPARES : 0);
}

/* Takes spikes out of light and its halves. Returns whether there may be some. Highlights of lobes,
 * whose rays are counted, are none. */
static bool find_spikes(const struct indirect *f, const struct indirect_rule *rule,
                        struct indirect_spikes *s)
{
    if (!has_spikes(f->plan) || f->count < 3 || f->patch->bounces) return false;
    if (indirect_spikes_reach(rule) == 0) return false;
    for (uint32_t c = 0; c < channels_of(f); c++)
        if (c < 3 || c >= f->count)
            s->channel[s->count++] = indirect_neighbourhood_spare(s->around, c);
    indirect_spikes_split(rule, s);
    return true;
}

static int run(const struct indirect *f, uint64_t *isolated)
{
    const struct indirect_rule rule = indirect_rule_of(f->plan);
    const struct indirect_kernels *kernels = KERNELS_BEST(indirect_kernels);
    const int32_t halo = indirect_halo_px(f->plan);
    const int32_t beyond = f->error ? indirect_variance_reach(&rule) : 0;
    const struct rect seen = rect_intersect(rect_grow(f->inner, halo), f->patch->rect);
    const struct rect wide = rect_intersect(rect_grow(f->inner, beyond), seen);
    struct indirect_neighbourhood around;
    const uint32_t spares = spares_of(f) + indirect_spikes_spares(INDIRECT_SPIKES_MAX);
    const int error = indirect_neighbourhood_create(f->plan, f->patch, seen, halo, spares, &around);
    if (error) return error;
    for (uint32_t c = 0; c < channels_of(f); c++) load(f, &around, c, c);
    struct indirect_spikes spikes = {
        .kernels = kernels, .around = &around, .rect = wide, .first = spares_of(f)};
    const bool split = find_spikes(f, &rule, &spikes);
    run_filter(f, &rule, kernels, wide, &around);
    if (split) indirect_spikes_spread(&rule, &spikes);
    fill_isolated(f, &rule, &around, isolated);
    store(f, &around, indirect_neighbourhood_spare(&around, channels_of(f)));
    if (f->error) run_error(f, &rule, kernels, wide, &around);
    indirect_neighbourhood_fini(&around);
    return 0;
}

static int filter(const struct indirect *f, struct indirect_statistics *statistics)
{
    if (!can_filter(f)) return ERR_RANGE;
    const uint64_t measured = patch_count_measured(f->patch, f->inner);
    const bool filtered = f->plan->indirect_filter != INDIRECT_FILTER_NONE && measured > 0;
    int error = 0;
    if (filtered || (f->error && measured > 0))
        error = run(f, &statistics->pixels_isolated);
    else
        copy(f);
    if (error) return error;
    statistics->pixels_filtered += filtered ? measured : 0;
    statistics->pixels_skipped += (uint64_t)rect_area(f->inner) - (filtered ? measured : 0);
    statistics->blocks_skipped += measured == 0 ? 1 : 0;
    return 0;
}

int indirect_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                    uint32_t count, const float *const *in, float *const *out, float *width_px,
                    struct indirect_statistics *statistics)
{
    const struct indirect f = {plan, patch, inner, count, in, out, width_px, NULL};
    return filter(&f, statistics);
}

int indirect_filter_with_error(const struct plan *plan, const struct patch *patch,
                               struct rect inner, uint32_t count, const float *const *in,
                               float *const *out, float *width_px,
                               const struct indirect_error *error,
                               struct indirect_statistics *statistics)
{
    const struct indirect f = {plan, patch, inner, count, in, out, width_px, error};
    if (count < 3 || !patch_knows_errors(plan)) return ERR_RANGE;
    return filter(&f, statistics);
}
