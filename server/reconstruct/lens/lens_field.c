#include "server/reconstruct/lens/lens_field.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/lens/lens_cells.h"

#define FINE_STRATA 8 /* an axis: from there on cells are half as large */

/* 1, 1.5, 2, 3, 4, 6, ... */
static float bound(uint32_t k)
{
    return (k & 1 ? 1.5f : 1.0f) * (float)(1u << k / 2);
}
_Static_assert(LENS_BANDS == 9, "bound(9) is LENS_SLOPE_MAX");

void lens_layer_slopes(uint32_t layer, float *low, float *high)
{
    if (layer < LENS_FOCUS) {
        const uint32_t band = LENS_FOCUS - 1 - layer;
        *low = bound(band);
        *high = band < LENS_BANDS ? bound(band + 1) : INFINITY;
    } else if (layer > LENS_FOCUS) {
        const uint32_t band = layer - LENS_FOCUS - 1;
        *low = band < LENS_BANDS ? nextafterf(-bound(band + 1), 0.0f) : -INFINITY;
        *high = nextafterf(-bound(band), 0.0f);
    } else {
        *low = nextafterf(-1.0f, 0.0f);
        *high = 1.0f;
    }
}

int32_t lens_cell_level(float most, uint32_t l)
{
    const int32_t level = most <= 3.0f ? -1 : most <= 8.0f ? 0 : most <= 16.0f ? 1 : 2;
    return l < FINE_STRATA ? level : level - 1;
}

static void place_lines(struct lens_field *f)
{
    const size_t area = (size_t)rect_area(f->seen);
    const uint32_t width = (uint32_t)rect_width(f->seen), l = f->l;
    const struct lens_aperture *aperture = &f->pattern.aperture;
    float *across = (float *)(void *)f->row; /* a row; nothing is placed yet */
    for (int32_t y = f->seen.y0; y < f->seen.y1; y++) {
        const size_t row = lens_seen(f, f->seen.x0, y);
        lens_pattern_jitters(&f->pattern, f->seen.x0, y, width, f->along + row, across);
        for (uint32_t i = 0; i < l; i++) {
            float *height = f->height + i * area + row, *left = f->left + i * area + row;
            float *chord = f->chord + i * area + row;
            f->kernels->lines(aperture, l, i, width, across, height, left, chord);
        }
    }
}

/* Bits of the layers of a row's samples, segment by segment, and those of all segments. */
static uint32_t find_row(const struct lens_field *f, uint32_t sample, int32_t y, uint32_t *out)
{
    const float *slope = lens_slopes(f, sample, f->known.x0, y);
    const uint32_t width = (uint32_t)rect_width(f->known);
    uint32_t all = 0;
    for (uint32_t x = 0; x < width; x += LENS_SEGMENT) {
        const uint32_t left = width - x;
        *out = f->kernels->layers(slope + x, left < LENS_SEGMENT ? left : LENS_SEGMENT);
        all |= *out++;
    }
    return all;
}

/* Layers of what lies in `rect`. */
static void find_layers(struct lens_field *f, struct rect rect)
{
    f->known = rect;
    f->segments = ((uint32_t)rect_width(rect) + LENS_SEGMENT - 1) / LENS_SEGMENT;
    f->all = 0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t row = (size_t)(y - rect.y0);
        uint32_t *any = f->any + row * f->segments;
        memset(any, 0, f->segments * sizeof *any);
        for (uint32_t j = 0; j < f->l * f->l; j++) {
            uint32_t *present = f->present + (row * f->l * f->l + j) * f->segments;
            f->all |= find_row(f, j, y, present);
            for (uint32_t k = 0; k < f->segments; k++) any[k] |= present[k];
        }
    }
}

/* Layers of columns x to end - 1 of a row, which lie in one segment. */
static uint32_t layers_within(const struct lens_field *f, int32_t x, int32_t end, int32_t y)
{
    uint32_t layers = 0;
    for (uint32_t j = 0; j < f->l * f->l; j++)
        layers |= f->kernels->layers(lens_slopes(f, j, x, y), (uint32_t)(end - x));
    return layers;
}

/* Layers of what lies in `seen`, to the pixel. */
static void find_all(struct lens_field *f)
{
    const struct rect r = f->seen;
    f->all = 0;
    for (int32_t y = r.y0; y < r.y1; y++) {
        const uint32_t *any = lens_any(f, y);
        for (uint32_t k = lens_segment(f, r.x0); k <= lens_segment(f, r.x1 - 1); k++) {
            const int32_t left = lens_segment_x(f, k), right = left + LENS_SEGMENT;
            const bool whole = left >= r.x0 && right <= r.x1;
            if ((any[k] | f->all) == f->all) continue;
            f->all |=
                whole ? any[k]
                      : layers_within(f, left > r.x0 ? left : r.x0, right < r.x1 ? right : r.x1, y);
        }
    }
}

static size_t padded(size_t floats)
{
    return (floats + 2 * SIMD_LANES - 1) / SIMD_LANES * SIMD_LANES;
}

static int allocate(struct lens_field *f)
{
    const size_t seen = padded((size_t)rect_area(f->seen)),
                 lines = padded(f->l * (size_t)rect_area(f->seen));
    const size_t wide = padded((size_t)rect_area(f->wide));
    const size_t row = padded((size_t)rect_width(f->seen));
    const uint32_t samples = f->l * f->l;
    const size_t segments = ((size_t)rect_width(f->seen) + LENS_SEGMENT - 1) / LENS_SEGMENT;
    const size_t any = padded((size_t)rect_height(f->seen) * segments);
    const size_t present = padded((size_t)rect_height(f->seen) * segments * samples);
    const size_t spans = padded(samples * sizeof *f->spans / sizeof(float));
    const size_t floats = 4 * seen + 3 * lines + LENS_VIEWS * wide + row + present + any + spans;
    float *at = f->memory = scratch_take(f->patch->scratch, floats * sizeof *at);
    if (!at) return ERR_MEMORY;
    f->along = at;
    f->slopes = f->along + seen;
    f->count = f->slopes + seen;
    f->pass = f->count + seen;
    f->height = f->pass + seen;
    f->left = f->height + lines;
    f->chord = f->left + lines;
    f->row = (uint32_t *)(void *)(f->chord + lines);
    f->present = (uint32_t *)(void *)(f->row + row);
    f->any = f->present + present;
    f->spans = (struct lens_span *)(void *)(f->any + any);
    at = (float *)(void *)(f->any + any) + spans;
    for (size_t k = 0; k < LENS_VIEWS; k++) f->view[k] = at + k * wide;
    memset(f->light[0], 0, (LENS_LIGHTS + 2) * wide * sizeof(float));
    for (size_t k = 0; k < LENS_GROUPS * wide; k++) f->through[0][k] = 1.0f;
    return 0;
}

/* Pixels that samples of the layers that there are reach over. */
static int32_t reach_of(const struct lens_field *f)
{
    int32_t most = LENS_FOCUS_REACH_PX;
    for (uint32_t layer = 0; layer < LENS_LAYERS; layer++) {
        const int32_t reach = f->all >> layer & 1u ? lens_cells_reach_px(layer, f->l) : 0;
        most = reach > most ? reach : most;
    }
    return most;
}

int lens_field_create(const struct plan *plan, const struct patch *patch, struct rect wide,
                      struct rect seen, struct lens_field *out)
{
    *out = (struct lens_field){.plan = plan,
                               .patch = patch,
                               .kernels = KERNELS_BEST(lens_kernels),
                               .l = plan->lens_strata_per_axis,
                               .wide = wide,
                               .seen = seen};
    const int error = allocate(out);
    if (error) return error;
    lens_pattern_init(&out->pattern, plan);
    lens_shape_init(&out->shape, &out->pattern.aperture);
    find_layers(out, seen);
    out->seen = rect_intersect(rect_grow(wide, reach_of(out)), seen);
    find_all(out);
    lens_spans(&out->pattern.aperture, out->l, out->spans);
    if (out->all != 1u << LENS_FOCUS) place_lines(out);
    return 0;
}

void lens_field_fini(struct lens_field *f)
{
    scratch_give(f->patch->scratch, f->memory);
}
