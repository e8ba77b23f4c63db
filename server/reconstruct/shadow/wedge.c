#include "server/reconstruct/shadow/wedge.h"

#include <math.h>
#include <string.h>

#define SLOPE_MIN 6e-5f /* what a half float and the tracer's clamp leave */
#define SLOPE_MAX 65504.0f
#define KAPPA_MAX 1e4f /* of slopes that are handed on */
/* With random jitter 8 px would be best. With the pattern's lattices a few pixels together cover
 * the light evenly. From 3 px on the noise hardly falls, and wider filters only add the change of
 * slopes over the window. The width shrinks with the fourth root of m(N) only, because the lattice
 * needs its few pixels at 256 spp, too. */
#define WIDTH_MAX_PX 3.5f
#define FILL_PASSES  3
#define FILL_REACH   (WEDGE_FILL_PX / FILL_PASSES)
#define RUN          64

bool wedge_is_occluded(const struct receiver_light *light, const struct patch *patch, size_t i)
{
    return patch->lights[light->index].slope_max[i] > 0.0f;
}

static float slope_within(float s)
{
    return s > SLOPE_MIN ? s < SLOPE_MAX ? s : SLOPE_MAX : SLOPE_MIN; /* NaN: the least */
}

/* Loads slopes as they were measured. */
static void load_own(const struct receiver_light *light, const struct patch *patch,
                     const struct receivers *r, struct wedges *out)
{
    const struct patch_light *p = &patch->lights[light->index];
    const struct rect seen = rect_intersect(r->rect, patch->rect);
    for (int32_t y = seen.y0; y < seen.y1; y++) {
        const size_t to = receivers_pixel(r, seen.x0, y), from = patch_pixel(patch, seen.x0, y);
        for (size_t i = 0; i < (size_t)rect_width(seen); i++) {
            if (!(p->slope_max[from + i] > 0.0f) || !receiver_is_lit(&r->pixels, to + i)) continue;
            const float s = slope_within(p->slope_min[from + i]);
            const float t = slope_within(p->slope_max[from + i]);
            out->least[to + i] = s < t ? s : t;
            out->most[to + i] = s < t ? t : s;
        }
    }
}

/* Marks pixels of which one of five in a row is set. `full` has room for the row. */
static void spread_row(const float *values, size_t width, uint8_t *full, uint8_t *out)
{
    memset(out, 0, width);
    for (size_t x = 0; x < width; x++) full[x] = values[x] >= 0.0f;
    for (size_t x = FILL_REACH; x + FILL_REACH < width; x++)
        out[x] = full[x - 2] | full[x - 1] | full[x] | full[x + 1] | full[x + 2];
}

struct fill {
    const struct receivers *receivers;
    const struct shadow_kernels *kernels;
    struct shadow_field field; /* as far as sum_slopes needs it */
    uint8_t *near;             /* width * height; then a row */
    uint32_t *pixels;          /* empty ones beside full ones */
    float *sums;               /* 3 a pixel */
};

/* Finds which pixels of row y are empty and have full ones within reach: full ones in `near`,
 * which are spread along rows. */
static void mark_empty(const struct fill *f, const float *values, size_t y, uint8_t *out)
{
    const size_t width = (size_t)f->field.width;
    const uint8_t *near = f->near + y * width;
    const float *own = values + y * width;
    for (size_t x = 0; x < width; x++) {
        const uint8_t *n = near + x;
        const uint8_t any = n[0] | n[width] | n[2 * width] | *(n - width) | *(n - 2 * width);
        out[x] = own[x] >= 0.0f ? 0 : any;
    }
}

static size_t find_empty(const struct fill *f, const float *values)
{
    const size_t width = (size_t)f->field.width, height = (size_t)f->field.height;
    uint8_t *row = f->near + width * height;
    size_t count = 0;
    for (size_t y = 0; y < height; y++)
        spread_row(values + y * width, width, row, f->near + y * width);
    for (size_t y = FILL_REACH; y + FILL_REACH < height; y++) {
        const uint8_t *at = row, *end = row + width;
        mark_empty(f, values, y, row);
        while ((at = memchr(at, 1, (size_t)(end - at))) != NULL) {
            const size_t i = y * width + (size_t)(at++ - row);
            if (receiver_is_lit(&f->receivers->pixels, i)) f->pixels[count++] = (uint32_t)i;
        }
    }
    return count;
}

/* Means over compatible neighbours, where there are any. */
static void fill_pass(const struct fill *f, float *least, float *most)
{
    const size_t count = find_empty(f, least);
    f->kernels->sum_slopes(&f->field, f->pixels, (uint32_t)count, least, most, f->sums);
    for (size_t k = 0; k < count; k++) {
        const float *s = f->sums + 3 * k;
        if (!(s[0] > 0.0f)) continue;
        least[f->pixels[k]] = s[1] / s[0];
        most[f->pixels[k]] = s[2] / s[0];
    }
}

/* Turns slopes into their inverses, which swaps least and most. */
static void invert(size_t area, struct wedges *w)
{
    for (size_t i = 0; i < area; i++) {
        const float s = w->least[i], t = w->most[i];
        const float most = s > 1.0f / KAPPA_MAX ? 1.0f / s : KAPPA_MAX;
        const float least = t > 1.0f / KAPPA_MAX ? 1.0f / t : KAPPA_MAX;
        w->most[i] = s >= 0.0f ? most : -1.0f;
        w->least[i] = s >= 0.0f ? least : -1.0f;
    }
}

int wedges_create(const struct receiver_light *light, const struct patch *patch,
                  const struct receivers *receivers, const struct shadow_kernels *kernels,
                  struct wedges *out)
{
    const size_t area = (size_t)rect_area(receivers->rect);
    struct fill fill = {.receivers = receivers, .kernels = kernels};
    struct scratch *from = patch->scratch;
    const size_t stride = area + SHADOW_PLANE_PAD;
    float *memory = scratch_take(from, 2 * stride * sizeof *memory);
    const size_t row = (size_t)rect_width(receivers->rect);
    uint8_t *scratch = scratch_take(from, area * (sizeof(uint32_t) + 3 * sizeof(float) + 1) + row);
    *out = (struct wedges){.scratch = from, .memory = memory};
    if (!memory || !scratch) {
        scratch_give(from, scratch);
        wedges_fini(out);
        return ERR_MEMORY;
    }
    out->most = memory;
    out->least = memory + stride;
    for (size_t i = 0; i < 2 * stride; i++) memory[i] = -1.0f;
    fill.field = (struct shadow_field){.width = rect_width(receivers->rect),
                                       .height = rect_height(receivers->rect),
                                       .pixels = &receivers->pixels};
    fill.pixels = (uint32_t *)(void *)scratch;
    fill.sums = (float *)(void *)(scratch + area * sizeof(uint32_t));
    fill.near = scratch + area * (sizeof(uint32_t) + 3 * sizeof(float));
    load_own(light, patch, receivers, out);
    fill_pass(&fill, out->least, out->most);
    invert(area, out);
    for (int pass = 1; pass < FILL_PASSES; pass++) fill_pass(&fill, out->least, out->most);
    scratch_give(from, scratch);
    return 0;
}

void wedges_fini(struct wedges *wedges)
{
    scratch_give(wedges->scratch, wedges->memory);
    *wedges = (struct wedges){0};
}

float wedge_scale(const struct plan *plan, uint32_t strata)
{
    return plan->mu * cbrtf(9.0f / (float)(strata * strata));
}

/* Returns the widest filter, in pixels: WIDTH_MAX_PX mu m(N)^(1/4). */
static float width_max_px(const struct plan *plan, uint32_t strata)
{
    return plan->mu * WIDTH_MAX_PX * sqrtf(sqrtf(cbrtf(9.0f / (float)(strata * strata))));
}

static size_t list_wedges(const struct wedges *wedges, size_t area, uint32_t *pixels)
{
    size_t count = 0;
    pixels[0] = 0;
    for (size_t i = 0; i < area; i++) {
        pixels[count] = (uint32_t)i;
        count += wedges->most[i] >= 0.0f;
    }
    return count;
}

/* Neighbours mostly have the same rows. */
static void need_rows(struct coverage *coverage, const struct shadow_pixels *p,
                      const uint32_t *pixels, size_t count)
{
    coverage_need(coverage, COVERAGE_WIDEST);
    for (int axis = 0; axis < 2; axis++) {
        int32_t last = COVERAGE_WIDEST;
        for (size_t k = 0; k < count; k++) {
            const int32_t row = p->weights[axis][pixels[k]];
            if (row != last) coverage_need(coverage, row);
            last = row;
        }
    }
}

int wedges_shear(const struct receiver_light *light, const struct wedges *wedges,
                 const struct shadow_kernels *kernels, struct coverage *coverage,
                 struct receivers *receivers)
{
    const size_t area = (size_t)rect_area(receivers->rect);
    const struct wedge_shear shear = {light, wedge_scale(light->plan, light->strata),
                                      width_max_px(light->plan, light->strata), coverage->rho_max};
    uint32_t *pixels = scratch_take(receivers->scratch, (area + 1) * sizeof *pixels);
    if (!pixels) return ERR_MEMORY;
    const size_t count = list_wedges(wedges, area, pixels);
    kernels->shear_receivers(&shear, pixels, (uint32_t)count, wedges->most, wedges->least,
                             &receivers->pixels);
    need_rows(coverage, &receivers->pixels, pixels, count);
    scratch_give(receivers->scratch, pixels);
    return 0;
}
