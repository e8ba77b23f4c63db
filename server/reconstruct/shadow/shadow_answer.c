#include "server/reconstruct/shadow/shadow_answer.h"

#include "server/reconstruct/shadow/axis_aligned.h"
#include "server/reconstruct/shadow/edge.h"
#include "server/reconstruct/shadow/sheared.h"

int32_t shadow_reach_px(uint32_t filter)
{
    return filter == SHADOW_FILTER_SHEARED ? SHEARED_REACH_PX : AXIS_ALIGNED_REACH_PX;
}

static size_t receiver_index(const struct receivers *r, int32_t x, int32_t y)
{
    return (size_t)(y - r->rect.y0) * (size_t)rect_width(r->rect) + (size_t)(x - r->rect.x0);
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

/* Returns the index in `inner` of a pixel of the receivers' rect. */
static size_t index_of(const struct shadow_block *s, const struct receivers *r, uint32_t pixel)
{
    const uint32_t row = (uint32_t)rect_width(r->rect);
    return shadow_block_pixel(s, r->rect.x0 + (int32_t)(pixel % row),
                              r->rect.y0 + (int32_t)(pixel / row));
}

static void store(const struct shadow_block *s, const struct receivers *r, uint32_t pixel,
                  float seen, float width)
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

/* Filters along edges, then the rest by the sheared filter. rest and seen have room for `count`
 * pixels. */
static int run_both(const struct shadow_block *s, struct receivers *r,
                    const struct coverage *coverage, const uint32_t *pixels, uint32_t count,
                    struct edge_answer *edges, uint32_t *rest, float *seen)
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

static int run_sheared(const struct shadow_block *s, struct receivers *r,
                       const struct wedges *wedges, const uint32_t *pixels, uint32_t count)
{
    struct coverage coverage;
    struct scratch *scratch = s->patch->scratch;
    const float rho_max =
        wedge_scale(s->plan, s->light.strata) * s->light.sigma_y[0] / s->light.rectangle.half[0];
    float *seen = scratch_take(scratch, count * sizeof *seen);
    uint32_t *rest = scratch_take(scratch, count * sizeof *rest);
    struct edge_answer *edges = scratch_take(scratch, count * sizeof *edges);
    int error = coverage_create(s->light.strata, s->light.rectangle.profile, rho_max, &coverage);
    if (!seen || !rest || !edges) error = ERR_MEMORY;
    if (!error) error = wedges_shear(&s->light, wedges, s->kernels, &coverage, r);
    if (!error) error = run_both(s, r, &coverage, pixels, count, edges, rest, seen);
    coverage_fini(&coverage);
    scratch_give(scratch, edges);
    scratch_give(scratch, rest);
    scratch_give(scratch, seen);
    return error;
}

static int run_axis_aligned(const struct shadow_block *s, const struct receivers *r,
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

/* Lists the pixels with an answer of the sheared filter whose light has sunk, and finds the
 * smallest rectangle around them. */
static uint32_t list_sunk(const struct shadow_block *s, const struct receivers *r,
                          const uint32_t *pixels, uint32_t count, uint32_t *out,
                          struct rect *around)
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

/* Runs the axis-aligned filter for sunk lights, after the sheared filter. */
static int run_sunk(const struct shadow_block *s, const struct receivers *r,
                    const struct wedges *wedges, const uint32_t *pixels, uint32_t count)
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

int shadow_answer(const struct shadow_block *s, struct rect shaded)
{
    const uint32_t filter = s->plan->shadow_filter;
    struct receivers receivers;
    struct wedges wedges = {0};
    uint32_t *pixels =
        scratch_take(s->patch->scratch, ((size_t)rect_area(shaded) + 1) * sizeof *pixels);
    uint32_t count = 0;
    int error =
        receivers_create(&s->light, s->patch, s->kernels,
                         rect_grow(shaded, shadow_reach_px(filter) + WEDGE_FILL_PX), &receivers);
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
