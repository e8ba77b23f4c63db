/* What pixels see of a layer. */
#include <immintrin.h>
#include <math.h>
#include <string.h>

#include "server/reconstruct/lens/lens_cells.h"

#define TAPS_MAX 1024 /* a disc of 17 cells' radius */
#define EVEN     0x88 /* of eight numbers */
#define ODD      0xdd

struct tap {
    struct lens_tap tap;
    uint32_t group;
    bool inner;
};

/* A row's pixels of one phase: those that lie in the same place of their cells. */
struct view {
    struct lens_field *f;
    const struct lens_cells *c;
    struct lens_tap taps[TAPS_MAX];
    struct lens_gather gather;
    struct lens_composite composite;
    float sums[LENS_GROUPS * LENS_SUMS * SIMD_LANES]; /* of some pixels of a row */
};

/* Finds the part of the lens that each group of taps covers, at the layer's middle. */
static void find_shares(struct view *view)
{
    const struct lens_cells *c = view->c;
    const float middle = c->fixed ? c->most : fabsf(c->middle);
    const float reach = middle * c->scale * view->f->shape.inradius + 0.5f;
    float all = 0.0f;
    float *share = view->composite.share;
    uint32_t tap = 0;
    for (uint32_t g = 0; g < LENS_GROUPS; g++) {
        share[g] = 0.0f;
        for (; tap < view->gather.end[g]; tap++) {
            const float in = reach - view->taps[tap].distance;
            share[g] += in > 1.0f ? 1.0f : in > 0.0f ? in : 0.0f;
        }
        all += share[g];
    }
    for (uint32_t g = 0; g < LENS_GROUPS; g++) share[g] /= all; /* the nearest tap is in */
    memcpy(view->composite.lens, view->f->shape.share, sizeof view->composite.lens);
}

/* Cells around that of a pixel, whose centre is px cells to the right and py down of the corner of
 * its first cell, that any slope of the layer takes there. */
static uint32_t list_taps(const struct view *view, float px, float py, struct tap taps[TAPS_MAX])
{
    const struct lens_cells *c = view->c;
    const float size = c->scale * view->f->shape.inradius;
    const float most = c->most * size + 0.5f, least = c->least * size - 0.5f;
    const int32_t reach = (int32_t)ceilf(c->most * c->scale) + 1;
    const float sign = c->middle < 0.0f ? -1.0f : 1.0f;
    uint32_t n = 0;
    for (int32_t y = -reach; y <= reach; y++) {
        for (int32_t x = -reach; x <= reach; x++) {
            const float dx = sign * ((float)x + 0.5f - px), dy = sign * ((float)y + 0.5f - py);
            const float distance = lens_shape_distance(&view->f->shape, dx, dy);
            if (distance >= most || n == TAPS_MAX) continue;
            taps[n].group = lens_shape_group(dx, dy);
            taps[n].inner = distance <= least;
            taps[n].tap.at = y * c->stride + (x & c->phase) * c->columns + (x >> c->fine);
            taps[n++].tap.distance = distance;
        }
    }
    return n;
}

/* Taps of one group, after the first n: those that are within the reach of every slope of the
 * layer, or the others. */
static uint32_t add_taps(struct view *view, const struct tap *taps, uint32_t count, uint32_t group,
                         bool inner, uint32_t n)
{
    for (uint32_t k = 0; k < count; k++)
        if (taps[k].group == group && taps[k].inner == inner) view->taps[n++] = taps[k].tap;
    return n;
}

static void find_taps(struct view *view, float px, float py)
{
    struct tap taps[TAPS_MAX];
    const uint32_t count = list_taps(view, px, py, taps);
    uint32_t n = 0;
    for (uint32_t g = 0; g < LENS_GROUPS; g++) {
        n = add_taps(view, taps, count, g, true, n);
        view->gather.inner[g] = n;
        n = add_taps(view, taps, count, g, false, n);
        view->gather.end[g] = n;
    }
    find_shares(view);
}

/* Bits of those of SIMD_LANES pixels that are near the layer: their cells are every 2^fine-th from
 * `column` on, those before `end`. */
static uint32_t near_lanes(const struct lens_cells *c, int32_t column, int32_t end, int32_t row)
{
    const uint8_t *tiles =
        c->near + (size_t)((row >> 3) - c->tiles.y0) * (size_t)rect_width(c->tiles);
    uint32_t near = 0;
    for (int32_t k = column >> 3; k <= (end - 1) >> 3; k++) {
        const int32_t from = k * LENS_TILE > column ? k * LENS_TILE - column : 0;
        const int32_t to = (k + 1) * LENS_TILE < end ? (k + 1) * LENS_TILE - column : end - column;
        const uint32_t first = (uint32_t)(from + c->phase) >> c->fine;
        const uint32_t last = (uint32_t)(to + c->phase) >> c->fine;
        if (tiles[k - c->tiles.x0]) near |= (1u << last) - (1u << first);
    }
    return near;
}

/* Loads pixels of a plane, `step` apart, into `count` lanes; the others are 0. */
static void load_lanes(const float *from, size_t step, size_t count, float to[SIMD_LANES])
{
    if (count < SIMD_LANES) {
        for (size_t i = 0; i < SIMD_LANES; i++) to[i] = i < count ? from[i * step] : 0.0f;
    } else if (step == 1) {
        memcpy(to, from, SIMD_LANES * sizeof *to);
    } else if (step == 2) {
        for (size_t i = 0; i < SIMD_LANES; i += 4)
            _mm_storeu_ps(to + i, _mm_shuffle_ps(_mm_loadu_ps(from + 2 * i),
                                                 _mm_loadu_ps(from + 2 * i + 4), EVEN));
    } else {
        for (size_t i = 0; i < SIMD_LANES; i += 4)
            _mm_storeu_ps(to + i, _mm_setr_ps(from[i * step], from[(i + 1) * step],
                                              from[(i + 2) * step], from[(i + 3) * step]));
    }
}

/* Every second number; those between stay. */
static void store_second(const float from[SIMD_LANES], float *to)
{
    for (size_t i = 0; i < SIMD_LANES; i += 4) {
        float *at = to + 2 * i;
        const __m128 new = _mm_loadu_ps(from + i);
        const __m128 old = _mm_shuffle_ps(_mm_loadu_ps(at), _mm_loadu_ps(at + 4), ODD);
        _mm_storeu_ps(at, _mm_unpacklo_ps(new, old));
        _mm_storeu_ps(at + 4, _mm_unpackhi_ps(new, old));
    }
}

/* The reverse. Numbers between pixels may be written unchanged. */
static void store_lanes(const float from[SIMD_LANES], size_t step, size_t count, float *to)
{
    if (count < SIMD_LANES) {
        for (size_t i = 0; i < count; i++) to[i * step] = from[i];
    } else if (step == 1) {
        memcpy(to, from, SIMD_LANES * sizeof *to);
    } else if (step == 2) {
        store_second(from, to);
    } else {
        for (size_t i = 0; i < SIMD_LANES; i += 4)
            for (size_t k = 0; k < 4; k++) to[(i + k) * step] = from[i + k];
    }
}

/* Loads what pixels have gathered, from pixel p of `wide` on. Returns whether any of them sees
 * beyond. */
static bool load_seen(const struct view *view, size_t count, size_t p,
                      float seen[LENS_VIEWS][SIMD_LANES])
{
    const struct lens_field *f = view->f;
    const size_t step = (size_t)1 << view->c->coarse;
    __m128 through = _mm_setzero_ps();
    for (int g = 0; g < LENS_GROUPS; g++) {
        load_lanes(f->through[g] + p, step, count, seen[g]);
        for (int i = 0; i < SIMD_LANES; i += 4)
            through = _mm_or_ps(through, _mm_loadu_ps(seen[g] + i));
    }
    if (_mm_movemask_ps(_mm_cmpgt_ps(through, _mm_setzero_ps())) == 0) return false;
    for (int k = LENS_GROUPS; k < LENS_VIEWS; k++) load_lanes(f->view[k] + p, step, count, seen[k]);
    return true;
}

/* Pixels x, x + step, ... of row y. Those that see nothing through what is nearer are done. */
static void composite_row(struct view *view, int32_t x, int32_t y)
{
    const struct lens_cells *c = view->c;
    const struct rect targets = c->targets;
    const int32_t step = 1 << c->coarse, row = y >> c->coarse << c->fine;
    const struct lens_kernels *kernels = view->f->kernels;
    for (int32_t first = x; first < targets.x1; first += SIMD_LANES * step) {
        const int32_t column = first >> c->coarse << c->fine;
        const int32_t left = (targets.x1 - first + step - 1) / step;
        const int32_t count = left < SIMD_LANES ? left : SIMD_LANES;
        const size_t p = lens_wide(view->f, first, y);
        float seen[LENS_VIEWS][SIMD_LANES];
        view->composite.near = near_lanes(c, column, column + (count << c->fine), row);
        if (!view->composite.near || !load_seen(view, (size_t)count, p, seen)) continue;
        const size_t at = (size_t)(row - c->rect.y0) * (size_t)c->stride +
                          (size_t)((column - c->rect.x0) >> c->fine);
        kernels->gather(&view->gather, at, SIMD_LANES, view->sums, SIMD_LANES);
        kernels->composite(&view->composite, seen);
        for (int k = 0; k < LENS_VIEWS; k++)
            store_lanes(seen[k], (size_t)step, (size_t)count, view->f->view[k] + p);
    }
}

void layer_composite(struct lens_field *f, const struct lens_cells *c)
{
    struct view view = {.f = f, .c = c};
    const int32_t step = 1 << c->coarse;
    for (int k = 0; k < LENS_CELL_PLANES; k++) view.gather.plane[k] = c->plane[k];
    view.gather.taps = view.taps;
    view.composite.sums = view.sums;
    view.composite.slope = fabsf(c->fixed ? c->most : c->middle);
    for (int32_t py = 0; py < step; py++) {
        for (int32_t px = 0; px < step; px++) {
            find_taps(&view, ((float)px + 0.5f) * c->scale, ((float)py + 0.5f) * c->scale);
            for (int32_t y = c->targets.y0 + ((py - c->targets.y0) & (step - 1)); y < c->targets.y1;
                 y += step)
                composite_row(&view, c->targets.x0 + ((px - c->targets.x0) & (step - 1)), y);
        }
    }
}
