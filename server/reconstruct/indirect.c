#include "server/reconstruct/indirect.h"

#include "server/reconstruct/indirect_blend.h"

/* One call: `count` channels over `inner`. */
struct indirect {
    const struct plan *plan;
    const struct patch *patch;
    struct rect inner;
    uint32_t count;
    const float *const *in;
    float *const *out;
    float *width_px; /* may be NULL */
};

int32_t indirect_halo_px(const struct plan *plan)
{
    const struct indirect_rule r = indirect_rule_of(plan);
    if (!(r.most_px > 0.0f)) return 0;
    return indirect_reach_px(r.most_px) + indirect_reach_px(r.smooth_most_px) + INDIRECT_NEAR_PX;
}

static bool can_filter(const struct indirect *f)
{
    const struct patch *p = f->patch;
    const struct rect common = rect_intersect(f->inner, p->rect);
    const uint32_t filter = f->plan->indirect_filter;
    const bool known = filter <= INDIRECT_FILTER_BLEND || filter == INDIRECT_FILTER_SHEARED;
    return known && p->depth && p->normal[0] && p->id && p->reflector && !rect_is_empty(f->inner) &&
           rect_area(common) == rect_area(f->inner) && f->count <= INDIRECT_CHANNELS_MAX;
}

/* What was measured, as it is. */
static void copy(const struct indirect *f)
{
    for (int32_t y = f->inner.y0; y < f->inner.y1; y++) {
        const size_t first = patch_pixel(f->patch, f->inner.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(f->inner); i++) {
            const bool measured = patch_is_measured(f->patch, i);
            for (uint32_t c = 0; c < f->count; c++) f->out[c][i] = measured ? f->in[c][i] : 0.0f;
            if (f->width_px) f->width_px[i] = 0.0f;
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

/* The channels into the place's first spares. */
static void load(const struct indirect *f, const struct indirect_place *place)
{
    const struct rect r = place->rect;
    for (int32_t y = r.y0; y < r.y1; y++) {
        const size_t to = indirect_place_index(place, r.x0, y);
        const size_t from = patch_pixel(f->patch, r.x0, y);
        for (uint32_t c = 0; c < f->count; c++)
            move_row(place->pixel + to, (size_t)rect_width(r), f->in[c] + from,
                     indirect_place_spare(place, c) + to);
    }
}

static void store(const struct indirect *f, const struct indirect_place *place, const float *beta)
{
    const size_t count = (size_t)rect_width(f->inner);
    for (int32_t y = f->inner.y0; y < f->inner.y1; y++) {
        const size_t from = indirect_place_index(place, f->inner.x0, y);
        const size_t to = patch_pixel(f->patch, f->inner.x0, y);
        const float *pixel = place->pixel + from;
        for (uint32_t c = 0; c < f->count; c++)
            move_row(pixel, count, indirect_place_spare(place, c) + from, f->out[c] + to);
        for (size_t i = 0; f->width_px && i < count; i++)
            f->width_px[to + i] = pixel[i] > 0.0f ? beta[from + i] / pixel[i] : 0.0f;
    }
}

/* Rules A and B. Spares: the channels, beta, what is between the passes. */
static void run_rule(const struct indirect *f, const struct indirect_rule *rule,
                     const struct indirect_kernels *kernels, struct indirect_place *place)
{
    const struct indirect_pass pass = {
        .kernels = kernels,
        .lines = f->plan->indirect_filter == INDIRECT_FILTER_LINEAR,
        .reach = indirect_reach_px(rule->most_px),
        .count = f->count,
    };
    const struct rect tall = indirect_pass_tall(place, f->inner, pass.reach);
    float *channels[INDIRECT_CHANNELS_MAX], *between[INDIRECT_CHANNELS_MAX];
    float *beta = indirect_place_spare(place, f->count);
    for (uint32_t c = 0; c < f->count; c++) {
        channels[c] = indirect_place_spare(place, c);
        between[c] = indirect_place_spare(place, f->count + 1 + c);
    }
    indirect_widths(rule, kernels, place, tall, beta);
    indirect_set_widths(rule, place, tall, beta, 1.0f);
    indirect_pass_run(&pass, place, f->inner, (const float *const *)channels, between, channels);
}

static int run(const struct indirect *f)
{
    const struct indirect_rule rule = indirect_rule_of(f->plan);
    const struct indirect_kernels *kernels = indirect_kernels_best();
    const bool blend = f->plan->indirect_filter == INDIRECT_FILTER_BLEND;
    const int32_t halo = indirect_halo_px(f->plan);
    const struct rect seen = rect_intersect(rect_grow(f->inner, halo), f->patch->rect);
    struct indirect_place place;
    const int error =
        indirect_place_create(f->plan, f->patch, seen, halo,
                              blend ? indirect_blend_spares(f->count) : 2 * f->count + 1, &place);
    if (error) return error;
    load(f, &place);
    if (blend)
        indirect_blend(&rule, kernels, &place, f->inner, f->count);
    else
        run_rule(f, &rule, kernels, &place);
    store(f, &place, indirect_place_spare(&place, f->count));
    indirect_place_fini(&place);
    return 0;
}

int indirect_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                    uint32_t count, const float *const *in, float *const *out, float *width_px,
                    struct indirect_statistics *statistics)
{
    const struct indirect f = {plan, patch, inner, count, in, out, width_px};
    if (!can_filter(&f)) return ERR_RANGE;
    const uint64_t measured = patch_count_measured(patch, inner);
    const bool filtered = plan->indirect_filter != INDIRECT_FILTER_NONE && measured > 0;
    int error = 0;
    if (filtered)
        error = run(&f);
    else
        copy(&f);
    if (error) return error;
    statistics->pixels_filtered += filtered ? measured : 0;
    statistics->pixels_skipped += (uint64_t)rect_area(inner) - (filtered ? measured : 0);
    statistics->blocks_skipped += measured == 0 ? 1 : 0;
    return 0;
}
