#include "server/reconstruct/lens/lens.h"

#include <math.h>
#include <string.h>

#include "proto/samples.h"
#include "server/reconstruct/lens/lens_axis_aligned.h"
#include "server/reconstruct/lens/lens_cells.h"
#include "server/reconstruct/lens/lens_residual.h"

/* Cells are largest where strata are few, whatever they are here. */
static int32_t reach_max_px(void)
{
    int32_t most = 0;
    for (uint32_t layer = 0; layer < LENS_LAYERS; layer++) {
        const int32_t reach = lens_cells_reach_px(layer, 1);
        most = reach > most ? reach : most;
    }
    return most;
}

int32_t lens_halo_px(const struct plan *plan)
{
    if (plan->lens_filter == LENS_FILTER_SHEARED)
        return reach_max_px() + lens_residual_reach_px(plan);
    return plan->lens_filter == LENS_FILTER_AXIS_ALIGNED ? LENS_AXIS_ALIGNED_REACH_PX : 0;
}

static bool can_filter(const struct plan *plan, const struct patch *p, struct rect inner)
{
    const struct rect common = rect_intersect(inner, p->rect);
    return plan->lens_filter <= LENS_FILTER_SHEARED && plan->lens_strata_per_axis > 0 &&
           p->lens_radiance && (plan->lens_filter == LENS_FILTER_NONE || p->lens_slope) &&
           !rect_is_empty(inner) && rect_area(common) == rect_area(inner);
}

/* Mean of the samples, in their order; those of a row. */
static void average_row(const struct plan *plan, const struct patch *patch, uint32_t channel,
                        size_t first, size_t count, float *out)
{
    const uint32_t samples = plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    const size_t area = (size_t)rect_area(patch->rect);
    memset(out, 0, count * sizeof *out);
    for (uint32_t j = 0; j < samples; j++) {
        const float *in = patch->lens_radiance + (j * 3 + channel) * area + first;
        for (size_t x = 0; x < count; x++) out[x] += in[x];
    }
    for (size_t x = 0; x < count; x++) out[x] /= (float)samples;
}

static void average(const struct plan *plan, const struct patch *patch, struct rect inner,
                    float *const out[3], float *width_px)
{
    const size_t count = (size_t)rect_width(inner);
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        const size_t first = patch_pixel(patch, inner.x0, y);
        for (uint32_t c = 0; c < 3; c++) average_row(plan, patch, c, first, count, out[c] + first);
        if (width_px) memset(width_px + first, 0, count * sizeof *width_px);
    }
}

/* What samples say of what is in focus. */
struct focus {
    float light[LENS_LIGHTS], met, all; /* sums; samples in focus, those there and beyond */
};

static void add_focus(const struct lens_field *f, int32_t x, int32_t y, struct focus *sum)
{
    float low, high;
    lens_layer_slopes(LENS_FOCUS, &low, &high);
    for (uint32_t j = 0; j < f->l * f->l; j++) {
        const float s = *lens_slopes(f, j, x, y);
        if (s >= high) continue;
        sum->all += 1.0f;
        if (s < low) continue;
        sum->met += 1.0f;
        for (uint32_t k = 0; k < 3; k++) {
            const float c = *lens_sample_light(f, j, k, x, y);
            sum->light[k] += c;
            sum->light[3] += c * c;
        }
    }
}

#define UNCOUNTED (-1.0f) /* of a row, in its first place */

static void forget_counts(const struct lens_field *f)
{
    for (int32_t y = f->seen.y0; y < f->seen.y1; y++)
        f->count[lens_seen(f, f->seen.x0, y)] = UNCOUNTED;
}

/* Finds the distance along the row to the next pixel with samples in focus. Beyond
 * LENS_FOCUS_REACH_PX it is any larger number. */
static void find_next(const float *counts, int32_t width, float *next)
{
    float from = LENS_FOCUS_REACH_PX + 1.0f;
    for (int32_t x = 0; x < width; x++) {
        from = counts[x] > 0.0f ? 0.0f : from + 1.0f;
        next[x] = from;
    }
    from = LENS_FOCUS_REACH_PX + 1.0f;
    for (int32_t x = width - 1; x >= 0; x--) {
        from = counts[x] > 0.0f ? 0.0f : from + 1.0f;
        next[x] = from < next[x] ? from : next[x];
    }
}

/* Counts how many samples in focus and beyond the pixels of a row of `seen` have; few rows are
 * asked for. Arrays of the layer at hand hold them, which this one has no use for. */
static void count_row(const struct lens_field *f, int32_t y)
{
    const size_t at = lens_seen(f, f->seen.x0, y), width = (size_t)rect_width(f->seen);
    float low, high;
    if (f->count[at] >= 0.0f) return;
    lens_layer_slopes(LENS_FOCUS, &low, &high);
    memset(f->slopes + at, 0, width * sizeof(float));
    memset(f->count + at, 0, width * sizeof(float));
    for (uint32_t j = 0; j < f->l * f->l; j++)
        f->kernels->slopes(lens_slopes(f, j, f->seen.x0, y), -INFINITY, high, (uint32_t)width,
                           f->slopes + at, f->count + at);
    find_next(f->count + at, (int32_t)width, f->pass + at);
}

/* The nearest pixel of row v that has samples in focus or beyond is that far, in rows or columns,
 * whichever are more; `ring` if none is nearer than that. */
static float find_in_row(const struct lens_field *f, int32_t x, int32_t y, int32_t v, float ring)
{
    if (v < f->seen.y0 || v >= f->seen.y1) return ring;
    count_row(f, v);
    const float across = f->pass[lens_seen(f, x, v)], down = (float)(v < y ? y - v : v - y);
    const float from = across > down ? across : down;
    return from < ring ? from : ring;
}

/* Returns the distance of the nearest such pixel; above LENS_FOCUS_REACH_PX there is none. */
static int32_t find_ring(const struct lens_field *f, int32_t x, int32_t y)
{
    float ring = LENS_FOCUS_REACH_PX + 1.0f;
    for (int32_t down = 0; down <= LENS_FOCUS_REACH_PX && (float)down < ring; down++) {
        ring = find_in_row(f, x, y, y - down, ring);
        ring = find_in_row(f, x, y, y + down, ring);
    }
    return (int32_t)ring;
}

/* Adds samples in focus from the nearest pixels around, for a pixel whose own samples are all
 * hidden by nearer surfaces. */
static void add_around(const struct lens_field *f, int32_t x, int32_t y, struct focus *sum)
{
    const struct rect r = f->seen;
    const int32_t k = find_ring(f, x, y);
    if (k > LENS_FOCUS_REACH_PX) return;
    for (int32_t v = y - k; v <= y + k; v++) {
        if (v < r.y0 || v >= r.y1) continue;
        count_row(f, v);
        const float *counts = f->count + lens_seen(f, r.x0, v);
        for (int32_t u = x - k; u <= x + k; u += v == y - k || v == y + k ? 1 : 2 * k)
            if (u >= r.x0 && u < r.x1 && counts[u - r.x0] > 0.0f) add_focus(f, u, v, sum);
    }
}

/* Composites samples in focus behind nearer layers. */
static void see_focus(struct lens_field *f, int32_t x, int32_t y, struct focus sum)
{
    const size_t p = lens_wide(f, x, y);
    float through = 0.0f;
    for (int g = 0; g < LENS_GROUPS; g++) through += f->through[g][p] * f->shape.share[g];
    if (!(through > 0.0f)) return;
    if (!(sum.all > 0.0f)) add_around(f, x, y, &sum);
    if (!(sum.met > 0.0f)) return;
    const float met = sum.met / sum.all;
    for (int g = 0; g < LENS_GROUPS; g++) f->through[g][p] *= 1.0f - met;
    for (uint32_t k = 0; k < LENS_LIGHTS; k++) f->light[k][p] += sum.light[k] / sum.all * through;
    f->share[p] += met * through;
}

static struct lens_focus focus_of(const struct lens_field *f, int32_t y)
{
    const int32_t x = f->wide.x0;
    const size_t p = lens_wide(f, x, y);
    struct lens_focus out = {.slope = lens_slopes(f, 0, x, y),
                             .light = lens_sample_light(f, 0, 0, x, y),
                             .area = (size_t)rect_area(f->patch->rect),
                             .samples = f->l * f->l,
                             .shares = f->share + p};
    lens_layer_slopes(LENS_FOCUS, &out.low, &out.high);
    for (int g = 0; g < LENS_GROUPS; g++) {
        out.share[g] = f->shape.share[g];
        out.through[g] = f->through[g] + p;
    }
    for (int k = 0; k < LENS_LIGHTS; k++) out.lights[k] = f->light[k] + p;
    return out;
}

/* Many pixels of a row at once, those that look for others' samples and the last few by themselves.
 */
static void composite_focus(struct lens_field *f)
{
    const struct rect r = f->wide;
    const uint32_t many = (uint32_t)rect_width(r) / SIMD_LANES * SIMD_LANES;
    forget_counts(f);
    for (int32_t y = r.y0; y < r.y1; y++) {
        const struct lens_focus row = focus_of(f, y);
        const uint32_t n = f->kernels->focus(&row, many, f->row);
        for (uint32_t k = 0; k < n; k++)
            see_focus(f, r.x0 + (int32_t)f->row[k], y, (struct focus){.met = 0.0f});
        for (int32_t x = r.x0 + (int32_t)many; x < r.x1; x++) {
            struct focus sum = {.met = 0.0f};
            add_focus(f, x, y, &sum);
            see_focus(f, x, y, sum);
        }
    }
}

static int composite_layer(struct lens_field *f, uint32_t layer)
{
    struct lens_cells cells;
    if (layer == LENS_FOCUS) {
        composite_focus(f);
        return 0;
    }
    const int error = lens_cells_create(f, layer, &cells);
    if (!error && !rect_is_empty(cells.targets)) {
        layer_splat(f, &cells);
        layer_composite(f, &cells);
    }
    lens_cells_fini(f, &cells);
    return error;
}

/* Means from sums. */
static void divide(struct lens_field *f)
{
    const size_t area = (size_t)rect_area(f->wide);
    for (size_t p = 0; p < area; p++) {
        const float share = f->share[p];
        for (int k = 0; k < LENS_LIGHTS; k++)
            f->light[k][p] = share > 0.0f ? f->light[k][p] / share : 0.0f;
        f->spread[p] = share > 0.0f ? f->spread[p] / share : 0.0f;
    }
}

static void count_pixels(const struct lens_field *f, struct rect inner, float *width_px,
                         struct lens_statistics *statistics)
{
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        for (int32_t x = inner.x0; x < inner.x1; x++) {
            const float slope = f->spread[lens_wide(f, x, y)];
            if (width_px) width_px[patch_pixel(f->patch, x, y)] = 0.5f * slope;
            statistics->pixels_filtered += slope > 0.0f ? 1 : 0;
            statistics->pixels_skipped += slope > 0.0f ? 0 : 1;
        }
    }
}

static int shear(const struct plan *plan, const struct patch *patch, struct rect inner,
                 float *const out[3], float *width_px, struct lens_statistics *statistics)
{
    const int32_t ring = lens_residual_reach_px(plan);
    const struct rect wide = rect_intersect(rect_grow(inner, ring), patch->rect);
    const struct rect seen = rect_intersect(rect_grow(inner, lens_halo_px(plan)), patch->rect);
    struct lens_field f;
    int error = lens_field_create(plan, patch, wide, seen, &f);
    const bool focused = !error && f.all == 1u << LENS_FOCUS;
    if (focused) {
        average(plan, patch, inner, out, width_px);
        statistics->pixels_skipped += (uint64_t)rect_area(inner);
        statistics->blocks_skipped++;
    }
    for (uint32_t layer = 0; !error && !focused && layer < LENS_LAYERS; layer++)
        if (f.all >> layer & 1u) error = composite_layer(&f, layer);
    if (!error && !focused) {
        divide(&f);
        error = lens_residual(&f, inner, out);
        count_pixels(&f, inner, width_px, statistics);
    }
    lens_field_fini(&f);
    return error;
}

int lens_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                float *const out[3], float *width_px, struct lens_statistics *statistics)
{
    if (!can_filter(plan, patch, inner)) return ERR_RANGE;
    if (plan->lens_filter == LENS_FILTER_SHEARED)
        return shear(plan, patch, inner, out, width_px, statistics);
    if (plan->lens_filter == LENS_FILTER_AXIS_ALIGNED)
        return lens_axis_aligned(plan, patch, inner, out, width_px, statistics);
    average(plan, patch, inner, out, width_px);
    statistics->pixels_skipped += (uint64_t)rect_area(inner);
    statistics->blocks_skipped++;
    return 0;
}
