#include "server/reconstruct/lens_cells.h"

#include <math.h>
#include <string.h>

#define SUMS        LENS_CELL_SUMS
#define SPARE_LEVEL 2 /* of cells, in digits of their side in pixels */
#define CLOSE_SHARE                                                                                \
    0.25f /* of a layer's end: slopes that a surface may have that goes on behind it */
#define FIXED_SHARE 0.5f /* of LENS_SLOPE_MOST: the radius of layers that are not projected */

/* More samples show finer cells. */
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
    c->fixed = layer == 0 || layer == LENS_LAYERS - 1;
    const float size = FIXED_SHARE * LENS_SLOPE_MOST;
    c->least = c->fixed ? size : fminf(fabsf(c->low), fabsf(c->high));
    c->most = c->fixed ? size : fmaxf(fabsf(c->low), fabsf(c->high));
    c->middle = c->fixed ? 0.0f : 0.5f * (c->low + c->high);
}

/* How far from a pixel cells are at most that it looks at: centres of those lie half a cell beyond
 * the aperture's edges, and up to a whole one beyond its corners. */
static int32_t look_px(const struct lens_cells *c)
{
    return (int32_t)ceilf(c->most) + (1 << c->coarse);
}

/* How far pixels are from it at most whose samples lie in such cells. Samples beyond layers behind
 * the focus move by slopes of their own, which may be larger. */
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

/* Where in `pixels` the layer's samples are. */
static struct rect find_box(const struct lens_field *f, uint32_t layer, struct rect pixels)
{
    struct rect box = {pixels.x1, pixels.y1, pixels.x0, pixels.y0};
    for (int32_t y = pixels.y0; y < pixels.y1; y++)
        for (uint32_t j = 0; j < f->l * f->l; j++)
            for (uint32_t k = 0; k < f->segments; k++) {
                const int32_t x = f->seen.x0 + (int32_t)k * LENS_SEGMENT;
                if (!(lens_present(f, j, y, k) >> layer & 1u)) continue;
                box.x0 = x < box.x0 ? x : box.x0;
                box.x1 = x + LENS_SEGMENT > box.x1 ? x + LENS_SEGMENT : box.x1;
                box.y0 = y < box.y0 ? y : box.y0;
                box.y1 = y + 1 > box.y1 ? y + 1 : box.y1;
            }
    return box;
}

/* Who can see the layer, which cells they look at, and which pixels those show. */
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

int lens_cells_create(const struct lens_field *f, uint32_t layer, struct lens_cells *out)
{
    struct lens_cells *c = out;
    *c = (struct lens_cells){.memory = NULL};
    find_slopes(layer, c);
    find_scale(f->l, c);
    find_rects(f, c);
    if (rect_is_empty(c->targets)) return 0;
    const int32_t width = rect_width(c->rect);
    c->columns = (width >> c->fine) + 1 + LENS_LANES;
    c->columns = (c->columns + LENS_LANES - 1) / LENS_LANES * LENS_LANES;
    c->stride = c->columns << c->fine;
    c->area = (size_t)c->stride * (size_t)rect_height(c->rect) + 2 * LENS_LANES;
    const size_t tiles = (size_t)rect_area(c->tiles);
    const size_t floats = (SUMS + LENS_CELL_PLANES) * c->area;
    c->memory = scratch_take(f->patch->scratch, floats * sizeof(float) + 4 * tiles);
    if (!c->memory) return ERR_MEMORY;
    c->sums = c->memory;
    for (int k = 0; k < LENS_CELL_PLANES; k++) c->plane[k] = c->sums + (SUMS + (size_t)k) * c->area;
    c->near = (uint8_t *)c->memory + floats * sizeof(float);
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

/* Where arrays of `seen` have the rows whose samples can lie in cells, and how many pixels. */
static size_t first_of(const struct lens_field *f, const struct lens_cells *c)
{
    return lens_seen(f, f->seen.x0, c->pixels.y0);
}
static size_t count_of(const struct lens_field *f, const struct lens_cells *c)
{
    return (size_t)rect_width(f->seen) * (size_t)rect_height(c->pixels);
}

/* No slopes are known yet; samples of a layer that is not projected stay where they are. */
static void clear_slopes(const struct lens_field *f, const struct lens_cells *c)
{
    const size_t first = first_of(f, c), bytes = count_of(f, c) * sizeof(float);
    memset(f->slopes + first, 0, bytes);
    memset(f->count + first, 0, bytes);
    memset(f->pass + first, 0, bytes);
}

/* Slopes by which pixels' samples pass the layer: those with which others of the pixel lie in it.
 */
static void find_pass(const struct lens_field *f, const struct lens_cells *c)
{
    const size_t first = first_of(f, c);
    f->kernels->passes(f->slopes + first, f->count + first, c->middle, c->fixed, count_of(f, c),
                       f->pass + first);
}

/* 1: every second row says enough of coarse cells. */
static int32_t last_digit(const struct lens_cells *c)
{
    return c->coarse >= SPARE_LEVEL ? 1 : 0;
}

static struct lens_place place_of(const struct lens_field *f, const struct lens_cells *c,
                                  bool beyond)
{
    return (struct lens_place){
        .strata_inverse = 1.0f / (float)f->l, /* l is at least 1 */
        .cells = c->scale,
        .fine = c->fine,
        .coarse = c->coarse,
        .low = c->low,
        .high = c->high,
        .close = c->low - CLOSE_SHARE * fabsf(c->low),
        .beyond = beyond,
        .fixed = c->fixed,
        .column = c->rect.x0,
        .columns = rect_width(c->rect),
        .rows = rect_height(c->rect),
        .stride = c->stride,
        .phase_step = c->columns,
        .next = (size_t)rect_width(f->patch->rect) << last_digit(c),
    };
}

static size_t tile_at(const struct lens_cells *c, int32_t column, int32_t row)
{
    return (size_t)(row - c->tiles.y0) * (size_t)rect_width(c->tiles) +
           (size_t)(column - c->tiles.x0);
}

/* Can samples of pixels x .. end - 1 of row y lie where somebody looks? */
static bool is_looked_at(const struct lens_cells *c, int32_t x, int32_t end, int32_t y)
{
    const struct rect t = c->tiles;
    int32_t row = y >> c->coarse << c->fine >> 3;
    row = row < t.y0 ? t.y0 : row >= t.y1 ? t.y1 - 1 : row;
    for (int32_t k = x >> c->coarse << c->fine >> 3; k <= (end - 1) >> c->coarse << c->fine >> 3;
         k++)
        if (c->from[tile_at(c, k < t.x0 ? t.x0 : k >= t.x1 ? t.x1 - 1 : k, row)]) return true;
    return false;
}

/* Samples j of columns x .. end - 1 of row y. */
static void add_run(const struct lens_field *f, struct lens_cells *c, uint32_t j, int32_t x,
                    int32_t end, int32_t y, struct lens_place *place)
{
    const uint32_t count = (uint32_t)(end - x);
    const size_t at = lens_seen(f, x, y), line = j / f->l * (size_t)rect_area(f->seen) + at;
    place->slope = lens_slopes(f, j, x, y);
    place->along = f->along + at;
    place->pass = f->pass + at;
    place->known = f->count + at;
    place->left = f->left + line;
    place->chord = f->chord + line;
    place->height = f->height + line;
    place->x = x;
    for (uint32_t k = 0; k < 3; k++) place->light[k] = lens_light(f, j, k, x, y);
    f->kernels->add(place, count, c->sums);
    if (!place->beyond)
        f->kernels->slopes(place->slope, c->low, c->high, count, f->slopes + at, f->count + at);
}

/* Samples j of row y, by runs of segments that have some. */
static void add_row(const struct lens_field *f, struct lens_cells *c, uint32_t j, int32_t y,
                    uint32_t wanted, struct lens_place *place)
{
    int32_t from = c->pixels.x1;
    place->row_phase = (float)(y & ((1 << c->coarse) - 1));
    place->row = c->rect.y0 - (y >> c->coarse << c->fine);
    for (uint32_t k = 0; k < f->segments; k++) {
        const int32_t left = f->seen.x0 + (int32_t)k * LENS_SEGMENT, right = left + LENS_SEGMENT;
        const int32_t x = left > c->pixels.x0 ? left : c->pixels.x0;
        const int32_t end = right < c->pixels.x1 ? right : c->pixels.x1;
        if (x >= end) continue;
        if ((lens_present(f, j, y, k) & wanted) && (!place->beyond || is_looked_at(c, x, end, y))) {
            from = x < from ? x : from;
            if (end < c->pixels.x1) continue;
            add_run(f, c, j, from, end, y, place);
        } else if (from < x) {
            add_run(f, c, j, from, x, y, place);
        }
        from = c->pixels.x1;
    }
}

/* All samples in the layer, or all beyond it, row by row: the cells of a row's samples are near
 * each other. */
static void add(const struct lens_field *f, struct lens_cells *c, bool beyond)
{
    const uint32_t wanted = beyond ? ~((2u << c->layer) - 1u) : 1u << c->layer;
    struct lens_place place = place_of(f, c, beyond);
    const int32_t last = last_digit(c);
    for (int32_t y = (c->pixels.y0 + last) & ~last; y < c->pixels.y1; y += 1 + last) {
        for (uint32_t j = 0; j < f->l * f->l; j++) {
            place.stratum = (float)(j % f->l);
            add_row(f, c, j, y, wanted, &place);
        }
    }
}

/* Where cell (column, row) of the picture is. */
static size_t cell_at(const struct lens_cells *c, int32_t column, int32_t row)
{
    const int32_t x = column - c->rect.x0, y = row - c->rect.y0;
    return (size_t)y * (size_t)c->stride + (size_t)((x & c->phase) * c->columns + (x >> c->fine));
}

static struct lens_finish finish_of(const struct lens_field *f, const struct lens_cells *c)
{
    struct lens_finish out = {.sums = c->sums,
                              .inradius = f->shape.inradius * c->scale,
                              .middle = c->fixed ? c->most : fabsf(c->middle),
                              .fixed = c->fixed};
    for (int k = 0; k < LENS_CELL_PLANES; k++) out.plane[k] = c->plane[k];
    return out;
}

/* Does a sample of the layer lie in one of the cells from `column` on? */
static bool has_samples(const struct lens_cells *c, int32_t column, int32_t end, int32_t row)
{
    for (int32_t phase = 0; phase <= c->phase && column + phase < end; phase++) {
        const float *samples = c->sums + SUMS * cell_at(c, column + phase, row) + 4;
        for (int32_t x = column + phase; x < end; x += 1 << c->fine, samples += SUMS)
            if (*samples > 0.0f) return true;
    }
    return false;
}

static void mark(struct lens_cells *c)
{
    const struct rect r = c->rect, t = c->tiles;
    for (int32_t y = r.y0; y < r.y1; y++) {
        uint8_t *near = c->near + tile_at(c, t.x0, y >> 3);
        for (int32_t k = t.x0; k < t.x1; k++, near++) {
            const int32_t x = k * LENS_TILE > r.x0 ? k * LENS_TILE : r.x0;
            const int32_t end = (k + 1) * LENS_TILE < r.x1 ? (k + 1) * LENS_TILE : r.x1;
            if (!*near) *near = has_samples(c, x, end, y);
        }
    }
}

/* Spreads marks by `tiles` to all sides. */
static void dilate(const struct lens_cells *c, int32_t tiles, const uint8_t *in, uint8_t *out)
{
    const int32_t width = rect_width(c->tiles), height = rect_height(c->tiles);
    memset(c->spare, 0, (size_t)width * (size_t)height);
    memset(out, 0, (size_t)width * (size_t)height);
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            for (int32_t k = x - tiles; in[y * width + x] && k <= x + tiles; k++)
                if (k >= 0 && k < width) c->spare[y * width + k] = 1;
    for (int32_t y = 0; y < height; y++)
        for (int32_t k = y - tiles; k <= y + tiles; k++)
            for (int32_t x = 0; k >= 0 && k < height && x < width; x++)
                out[k * width + x] |= c->spare[y * width + x];
}

/* Cells that somebody looks at, row by row, in runs of tiles. */
static void finish(const struct lens_field *f, struct lens_cells *c)
{
    const struct rect r = c->rect, t = c->tiles;
    const struct lens_finish planes = finish_of(f, c);
    for (int32_t y = r.y0; y < r.y1; y++) {
        for (int32_t k = t.x0; k < t.x1; k++) {
            const int32_t first = k;
            while (k < t.x1 && c->read[tile_at(c, k, y >> 3)]) k++;
            const int32_t x = first * LENS_TILE > r.x0 ? first * LENS_TILE : r.x0;
            const int32_t end = k * LENS_TILE < r.x1 ? k * LENS_TILE : r.x1;
            if (k == first || x >= end) continue;
            for (int32_t phase = 0; phase <= c->phase && x + phase < end; phase++)
                f->kernels->finish(&planes, cell_at(c, x + phase, y),
                                   (size_t)((end - 1 - x - phase) >> c->fine) + 1);
        }
    }
}

void lens_cells_fill(const struct lens_field *f, struct lens_cells *c)
{
    const int32_t tiles = ((int32_t)ceilf(c->most * c->scale) + 1 + LENS_TILE - 1) / LENS_TILE;
    clear_slopes(f, c);
    add(f, c, false);
    mark(c);
    memcpy(c->read, c->near, (size_t)rect_area(c->tiles));
    dilate(c, tiles, c->read, c->near);
    dilate(c, tiles, c->near, c->read);
    dilate(c, tiles, c->read, c->from);
    if (f->all & ~((2u << c->layer) - 1u)) {
        find_pass(f, c);
        add(f, c, true);
    }
    finish(f, c);
}
