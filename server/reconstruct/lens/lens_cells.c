#include "server/reconstruct/lens/lens_cells.h"

#include <math.h>
#include <string.h>

#define SUMS LENS_CELL_SUMS
#define CLOSE_SHARE                                                                                \
    0.25f /* of a layer's end: slopes that a surface may have that goes on behind it */
#define FIXED_SHARE 0.5f /* of LENS_SLOPE_MAX: the radius of layers that are not projected */

/* Chooses the size of cells, which is finer with more samples. */
static void find_scale(uint32_t l, struct lens_cells *c)
{
    const int32_t level = lens_cell_level(c->most, l);
    c->coarse = level > 0 ? level : 0;
    c->fine = level < 0 ? -level : 0;
    c->phase = (1 << c->fine) - 1;
    c->scale = (float)(1 << c->fine) / (float)(1 << c->coarse);
}

static void find_slopes(uint32_t layer, struct lens_cells *c)
{
    lens_layer_slopes(layer, &c->low, &c->high);
    c->layer = layer;
    c->close = c->low - CLOSE_SHARE * fabsf(c->low);
    c->fixed = layer == 0 || layer == LENS_LAYERS - 1;
    const float size = FIXED_SHARE * LENS_SLOPE_MAX;
    c->least = c->fixed ? size : fminf(fabsf(c->low), fabsf(c->high));
    c->most = c->fixed ? size : fmaxf(fabsf(c->low), fabsf(c->high));
    c->middle = c->fixed ? 0.0f : 0.5f * (c->low + c->high);
}

/* Returns the greatest distance from a pixel to a cell that it reads. Centres of such cells lie
 * half a cell beyond the aperture's edges, and up to a whole one beyond its corners. */
static int32_t look_px(const struct lens_cells *c)
{
    return (int32_t)ceilf(c->most) + (1 << c->coarse);
}

/* Returns the greatest distance to a pixel whose samples lie in such cells. Samples beyond layers
 * behind the focus move by slopes of their own, which may be larger. */
static int32_t reach_px(const struct lens_cells *c)
{
    const float moved = c->low < 0.0f && !c->fixed ? c->most * (1.0f + CLOSE_SHARE) : c->most;
    const float cell = (float)(1 << c->coarse) / (float)(1 << c->fine);
    return (int32_t)ceilf(c->most + moved) + (int32_t)ceilf(1.5f * cell);
}

int32_t lens_cells_reach_px(uint32_t layer, uint32_t l)
{
    struct lens_cells c;
    if (layer == LENS_FOCUS) return LENS_FOCUS_REACH_PX;
    find_slopes(layer, &c);
    find_scale(l, &c);
    return reach_px(&c);
}

/* Cells are those that reach into what pixels look at. */
int32_t lens_cells_around_px(uint32_t layer, uint32_t l)
{
    struct lens_cells c;
    find_slopes(layer, &c);
    find_scale(l, &c);
    return look_px(&c) + (1 << c.coarse) + 1;
}

/* Finds the box of the layer's samples in `pixels`, to the segment. */
static struct rect find_box(const struct lens_field *f, uint32_t layer, struct rect pixels)
{
    struct rect box = {pixels.x1, pixels.y1, pixels.x0, pixels.y0};
    for (int32_t y = pixels.y0; y < pixels.y1; y++) {
        const uint32_t *any = lens_any(f, y);
        for (uint32_t k = lens_segment(f, pixels.x0); k <= lens_segment(f, pixels.x1 - 1); k++) {
            const int32_t x = lens_segment_x(f, k);
            if (!(any[k] >> layer & 1u)) continue;
            box.x0 = x < box.x0 ? x : box.x0;
            box.x1 = x + LENS_SEGMENT > box.x1 ? x + LENS_SEGMENT : box.x1;
            box.y0 = y < box.y0 ? y : box.y0;
            box.y1 = y + 1;
        }
    }
    return rect_intersect(box, pixels);
}

/* Finds the pixels that can see the layer, the cells they see, and the pixels whose samples lie in
 * those. */
static void find_rects(const struct lens_field *f, struct lens_cells *c)
{
    const int32_t reach = reach_px(c), down = c->coarse;
    const struct rect near = rect_intersect(rect_grow(f->wide, reach), f->seen);
    const struct rect box = find_box(f, c->layer, near);
    if (rect_is_empty(box)) return;
    c->targets = rect_intersect(rect_grow(box, reach), f->wide);
    if (rect_is_empty(c->targets)) return;
    const struct rect looked = rect_grow(c->targets, look_px(c));
    const int32_t cells = 1 << c->fine;
    c->rect = (struct rect){(looked.x0 >> down) * cells, (looked.y0 >> down) * cells,
                            ((looked.x1 >> down) + 1) * cells, ((looked.y1 >> down) + 1) * cells};
    c->pixels = rect_intersect(rect_grow(c->targets, reach), f->seen);
    c->tiles = (struct rect){c->rect.x0 >> 3, c->rect.y0 >> 3, (c->rect.x1 >> 3) + 1,
                             (c->rect.y1 >> 3) + 1};
}
_Static_assert(LENS_TILE == 1 << 3, "tiles are found by shifts");

/* The pixels whose samples lie in cells, where these lie within `span` of the lens: to the one side
 * by as much as they move to the other. A pixel more, for what is rounded. */
static struct rect find_window(const struct lens_cells *c, const struct lens_span *span)
{
    const float low = fminf(c->low, c->close), inverse = 1.0f / c->scale; /* a power of two */
    float least[2], most[2];
    for (int axis = 0; axis < 2; axis++) {
        const float a = low * span->low[axis], b = low * span->high[axis];
        const float d = c->high * span->low[axis], e = c->high * span->high[axis];
        least[axis] = c->fixed ? 0.0f : fminf(fminf(a, b), fminf(d, e));
        most[axis] = c->fixed ? 0.0f : fmaxf(fmaxf(a, b), fmaxf(d, e));
    }
    const struct rect window = {(int32_t)floorf((float)c->rect.x0 * inverse - most[0]) - 1,
                                (int32_t)floorf((float)c->rect.y0 * inverse - most[1]) - 1,
                                (int32_t)ceilf((float)c->rect.x1 * inverse - least[0]) + 1,
                                (int32_t)ceilf((float)c->rect.y1 * inverse - least[1]) + 1};
    return rect_intersect(window, c->pixels);
}

int lens_cells_create(const struct lens_field *f, uint32_t layer, struct lens_cells *out)
{
    struct lens_cells *c = out;
    *c = (struct lens_cells){.memory = NULL};
    find_slopes(layer, c);
    find_scale(f->l, c);
    find_rects(f, c);
    if (rect_is_empty(c->targets)) return 0;
    const int32_t width = rect_width(c->rect);
    c->columns = (width >> c->fine) + 1 + SIMD_LANES;
    c->columns = (c->columns + SIMD_LANES - 1) / SIMD_LANES * SIMD_LANES;
    c->stride = c->columns << c->fine;
    c->area = (size_t)c->stride * (size_t)rect_height(c->rect) + 2 * SIMD_LANES;
    const size_t tiles = (size_t)rect_area(c->tiles);
    const size_t floats = (SUMS + LENS_CELL_PLANES) * c->area, samples = f->l * f->l;
    c->memory = scratch_take(f->patch->scratch,
                             floats * sizeof(float) + samples * sizeof *c->windows + 4 * tiles);
    if (!c->memory) return ERR_MEMORY;
    c->sums = c->memory;
    for (int k = 0; k < LENS_CELL_PLANES; k++) c->plane[k] = c->sums + (SUMS + (size_t)k) * c->area;
    c->windows = (struct rect *)(void *)(c->sums + floats);
    for (size_t j = 0; j < samples; j++) c->windows[j] = find_window(c, &f->spans[j]);
    c->near = (uint8_t *)(c->windows + samples);
    c->read = c->near + tiles;
    c->from = c->read + tiles;
    c->spare = c->from + tiles;
    memset(c->sums, 0, SUMS * c->area * sizeof(float));
    memset(c->near, 0, tiles);
    return 0;
}

void lens_cells_fini(const struct lens_field *f, struct lens_cells *c)
{
    scratch_give(f->patch->scratch, c->memory);
}
