/* What lens samples say of a layer's cells. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/lens/lens_cells.h"

#define SUMS        LENS_CELL_SUMS
#define SPARE_LEVEL 2 /* of cells, in digits of their side in pixels */

/* 1: every second row says enough of coarse cells. */
static int32_t last_digit(const struct lens_cells *c)
{
    return c->coarse >= SPARE_LEVEL ? 1 : 0;
}

/* Returns how rows of `seen` are splatted. */
static struct lens_splat splat_of(const struct lens_field *f, const struct lens_cells *c,
                                  bool beyond)
{
    return (struct lens_splat){
        .strata_inverse = 1.0f / (float)f->l, /* l is at least 1 */
        .cells = c->scale,
        .fine = c->fine,
        .coarse = c->coarse,
        .low = c->low,
        .high = c->high,
        .close = c->close,
        .beyond = beyond,
        .fixed = c->fixed,
        .column = c->rect.x0,
        .columns = rect_width(c->rect),
        .rows = rect_height(c->rect),
        .stride = c->stride,
        .phase_step = c->columns,
        .spare = (int32_t)c->area - SIMD_LANES,
        .next = (size_t)rect_width(f->patch->rect) << last_digit(c),
    };
}

static size_t tile_at(const struct lens_cells *c, int32_t column, int32_t row)
{
    return (size_t)(row - c->tiles.y0) * (size_t)rect_width(c->tiles) +
           (size_t)(column - c->tiles.x0);
}

/* Returns whether samples of pixels x .. end - 1 of row y can lie in visible cells. */
static bool is_visible(const struct lens_cells *c, int32_t x, int32_t end, int32_t y)
{
    const struct rect t = c->tiles;
    int32_t row = y >> c->coarse << c->fine >> 3;
    row = row < t.y0 ? t.y0 : row >= t.y1 ? t.y1 - 1 : row;
    for (int32_t k = x >> c->coarse << c->fine >> 3; k <= (end - 1) >> c->coarse << c->fine >> 3;
         k++)
        if (c->from[tile_at(c, k < t.x0 ? t.x0 : k >= t.x1 ? t.x1 - 1 : k, row)]) return true;
    return false;
}

/* Columns of a row. */
struct run {
    int32_t x, end;
};

static struct run run_of(struct rect r)
{
    return (struct run){r.x0, r.x1};
}

/* The next run of segments within `in`, from segment *k on, that have one of those layers. */
static bool next_run(const struct lens_field *f, const uint32_t *layers, uint32_t wanted,
                     struct run in, uint32_t *k, struct run *out)
{
    const uint32_t end = lens_segment(f, in.end - 1) + 1;
    uint32_t first = *k, last;
    while (first < end && !(layers[first] & wanted)) first++;
    for (last = first; last < end && (layers[last] & wanted);) last++;
    const int32_t left = lens_segment_x(f, first), right = lens_segment_x(f, last);
    *k = last;
    *out = (struct run){left > in.x ? left : in.x, right < in.end ? right : in.end};
    return first < end;
}

static size_t column(const struct lens_field *f, int32_t x)
{
    return (size_t)(x - f->seen.x0);
}

/* Samples j of columns of row y. */
static void add_run(const struct lens_field *f, const struct lens_cells *c, uint32_t j,
                    struct run run, int32_t y, struct lens_splat *splat)
{
    const size_t at = lens_seen(f, run.x, y), line = j / f->l * (size_t)rect_area(f->seen) + at;
    splat->slope = lens_slopes(f, j, run.x, y);
    splat->along = f->along + at;
    splat->pass = f->pass + column(f, run.x);
    splat->known = f->count + column(f, run.x);
    splat->left = f->left + line;
    splat->chord = f->chord + line;
    splat->height = f->height + line;
    splat->x = run.x;
    splat->stratum = (float)(j % f->l);
    for (uint32_t k = 0; k < 3; k++) splat->light[k] = lens_sample_light(f, j, k, run.x, y);
    f->kernels->add(splat, (uint32_t)(run.end - run.x), c->sums);
}

/* Samples of row y within `in`, by runs of segments that have some. */
static void add_row(const struct lens_field *f, const struct lens_cells *c, struct run in,
                    int32_t y, uint32_t wanted, struct lens_splat *splat)
{
    splat->row_phase = (float)(y & ((1 << c->coarse) - 1));
    splat->row = c->rect.y0 - (y >> c->coarse << c->fine);
    for (uint32_t j = 0; j < f->l * f->l; j++) {
        const struct rect w = c->windows[j];
        const struct run near = {w.x0 > in.x ? w.x0 : in.x, w.x1 < in.end ? w.x1 : in.end};
        struct run run;
        if (y < w.y0 || y >= w.y1 || near.x >= near.end) continue;
        uint32_t k = lens_segment(f, near.x);
        while (next_run(f, lens_present(f, j, y), wanted, near, &k, &run))
            add_run(f, c, j, run, y, splat);
    }
}

/* The first row whose samples are read: every second one of coarse cells, whatever the block. */
static int32_t first_row(const struct lens_cells *c)
{
    return (c->pixels.y0 + last_digit(c)) & ~last_digit(c);
}

/* Adds all samples in the layer, row by row, because the cells of a row's samples are near each
 * other. */
static void add_own(const struct lens_field *f, const struct lens_cells *c)
{
    struct lens_splat splat = splat_of(f, c, false);
    memset(f->pass, 0, (size_t)rect_width(f->seen) * sizeof(float));
    for (int32_t y = first_row(c); y < c->pixels.y1; y += 1 + last_digit(c)) {
        struct run run;
        uint32_t k = lens_segment(f, c->pixels.x0);
        if (next_run(f, lens_any(f, y), 1u << c->layer, run_of(c->pixels), &k, &run))
            add_row(f, c, run_of(c->pixels), y, 1u << c->layer, &splat);
    }
}

/* Slopes by which pixels' samples pass the layer: those with which others of the pixel lie in it.
 */
static void find_pass(const struct lens_field *f, const struct lens_cells *c, struct run in,
                      int32_t y)
{
    const size_t at = column(f, in.x), count = (size_t)(in.end - in.x);
    memset(f->slopes + at, 0, count * sizeof(float));
    memset(f->count + at, 0, count * sizeof(float));
    for (uint32_t j = 0; j < f->l * f->l; j++) {
        uint32_t k = lens_segment(f, in.x);
        struct run run;
        while (next_run(f, lens_present(f, j, y), 1u << c->layer, in, &k, &run))
            f->kernels->slopes(lens_slopes(f, j, run.x, y), c->low, c->high,
                               (uint32_t)(run.end - run.x), f->slopes + column(f, run.x),
                               f->count + column(f, run.x));
    }
    f->kernels->passes(f->slopes + at, f->count + at, c->middle, c->fixed, count, f->pass + at);
}

/* The next run of segments of row y, from segment *k on, that have samples beyond the layer and lie
 * in visible cells. */
static bool next_visible(const struct lens_field *f, const struct lens_cells *c, int32_t y,
                         uint32_t beyond, uint32_t *k, struct run *out)
{
    const struct rect p = c->pixels;
    const uint32_t *layers = lens_any(f, y), end = lens_segment(f, p.x1 - 1) + 1;
    bool found = false;
    for (; *k < end; ++*k) {
        const int32_t left = lens_segment_x(f, *k), right = left + LENS_SEGMENT;
        const struct run run = {left > p.x0 ? left : p.x0, right < p.x1 ? right : p.x1};
        if (!(layers[*k] & beyond) || !is_visible(c, run.x, run.end, y)) {
            if (found) return true;
            continue;
        }
        out->x = found ? out->x : run.x;
        out->end = run.end;
        found = true;
    }
    return found;
}

/* Adds all samples beyond the layer to visible cells. */
static void add_beyond(const struct lens_field *f, const struct lens_cells *c)
{
    const uint32_t beyond = ~((2u << c->layer) - 1u);
    struct lens_splat splat = splat_of(f, c, true);
    for (int32_t y = first_row(c); y < c->pixels.y1; y += 1 + last_digit(c)) {
        uint32_t k = lens_segment(f, c->pixels.x0);
        struct run run;
        while (next_visible(f, c, y, beyond, &k, &run)) {
            find_pass(f, c, run, y);
            add_row(f, c, run, y, beyond, &splat);
        }
    }
}

/* Returns the index of cell (column, row) of the picture. */
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

/* Returns whether a sample of the layer lies in one of the cells from `column` on. */
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

/* Visible cells, row by row, in runs of tiles. */
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

void layer_splat(const struct lens_field *f, struct lens_cells *c)
{
    const int32_t tiles = ((int32_t)ceilf(c->most * c->scale) + 1 + LENS_TILE - 1) / LENS_TILE;
    add_own(f, c);
    mark(c);
    memcpy(c->read, c->near, (size_t)rect_area(c->tiles));
    dilate(c, tiles, c->read, c->near);
    dilate(c, tiles, c->near, c->read);
    dilate(c, tiles, c->read, c->from);
    if (f->all & ~((2u << c->layer) - 1u)) add_beyond(f, c);
    finish(f, c);
}
