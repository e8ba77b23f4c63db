/* From a film's tiles to the patch that a block reads. */
#include <assert.h>

#include "server/film/film_work.h"
#include "server/film/gather.h"
#include "server/film/gather_lone.h"
#include "server/film/gather_mixed.h"

void film_gather_in(struct film *film, struct scratch *scratch)
{
    film->scratch = scratch;
}

/* Light of lone sub-samples of all tiles in *t. */
static int gather_lone(const struct film *film, struct rect t, struct patch *patch)
{
    uint32_t count = 0;
    if (!(film->plan->planes & PLANE_BIT(LONE))) return 0;
    for (int32_t row = t.y0; row < t.y1; row++)
        for (int32_t column = t.x0; column < t.x1; column++) {
            const uint32_t tile = film_tile_at(film, column, row);
            count += gather_lone_count(film->plan, film->tiles[tile].samples,
                                       tile_grid_rect(&film->grid, tile), patch);
        }
    const int error = gather_lone_reserve(film->plan, count, patch);
    if (error) return error;
    for (int32_t row = t.y0; row < t.y1; row++)
        for (int32_t column = t.x0; column < t.x1; column++) {
            const uint32_t tile = film_tile_at(film, column, row);
            gather_lone_tile(film->plan, film->tiles[tile].samples,
                             tile_grid_rect(&film->grid, tile), patch);
        }
    lone_share_sort(&patch->lone);
    return 0;
}

/* Entries of mixed pixels, likewise. */
static int gather_mixed(const struct film *film, struct rect t, struct patch *patch)
{
    uint32_t count = 0;
    if (!(film->plan->planes & PLANE_BIT(MIXED))) return 0;
    for (int32_t row = t.y0; row < t.y1; row++)
        for (int32_t column = t.x0; column < t.x1; column++) {
            const uint32_t tile = film_tile_at(film, column, row);
            count += gather_mixed_count(film->tiles[tile].samples,
                                        tile_grid_rect(&film->grid, tile), patch);
        }
    const int error = gather_mixed_reserve(count, patch);
    if (error) return error;
    for (int32_t row = t.y0; row < t.y1; row++)
        for (int32_t column = t.x0; column < t.x1; column++) {
            const uint32_t tile = film_tile_at(film, column, row);
            gather_mixed_tile(film->tiles[tile].samples, tile_grid_rect(&film->grid, tile), patch);
        }
    mixed_share_sort(&patch->mixed, (size_t)rect_area(patch->rect));
    return 0;
}

/* Gathers the tiles that a range of columns and rows has, into a patch of `reach`. */
static int gather(const struct film *film, struct rect t, struct rect reach, struct rect core,
                  struct patch **out)
{
    struct patch *patch;
    *out = NULL;
    int error = patch_create_in(film->scratch, film->plan, reach, &patch);
    if (error) return error;
    patch->core = rect_intersect(core, patch->rect);
    for (int32_t row = t.y0; row < t.y1; row++) {
        for (int32_t column = t.x0; column < t.x1; column++) {
            uint32_t tile = film_tile_at(film, column, row);
            const struct film_tile *from = &film->tiles[tile];
            gather_tile(film->plan, from->samples, from->counts, tile_grid_rect(&film->grid, tile),
                        patch);
        }
    }
    error = gather_lone(film, t, patch);
    if (!error) error = gather_mixed(film, t, patch);
    if (error) patch_destroy(&patch);
    *out = patch;
    return error;
}

int film_gather(const struct film *film, uint32_t block, struct patch **out)
{
    assert(block < film->block_count && film->blocks[block].state == BLOCK_OUT);
    const struct rect area = film_block_rect(film, block);
    return gather(film, film_tiles_of(film, block), film_reach(film, area),
                  rect_grow(area, film->core_px), out);
}

/* The least rectangle around both; `a` may be empty. */
static struct rect join(struct rect a, struct rect b)
{
    if (rect_is_empty(a)) return b;
    return (struct rect){a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0,
                         a.x1 > b.x1 ? a.x1 : b.x1, a.y1 > b.y1 ? a.y1 : b.y1};
}

/* Returns the part of a tile within `area` that shows surfaces. */
static struct rect shown_of_tile(const struct film *film, uint32_t tile, struct rect area)
{
    const struct rect all = tile_grid_rect(&film->grid, tile), r = rect_intersect(all, area);
    const float *coverage = samples_f32(film->tiles[tile].samples, PLANE_PATH_COVERAGE, 0);
    struct rect shown = {0, 0, 0, 0};
    for (int32_t y = r.y0; y < r.y1; y++) {
        const float *row = coverage + (ptrdiff_t)(y - all.y0) * rect_width(all) - all.x0;
        int32_t x0 = r.x0, x1 = r.x1;
        while (x0 < x1 && row[x0] == 0.0f) x0++;
        while (x0 < x1 && row[x1 - 1] == 0.0f) x1--;
        if (x0 < x1) shown = join(shown, (struct rect){x0, y, x1, y + 1});
    }
    return shown;
}

/* Does the same for all tiles. */
static struct rect find_shown(const struct film *film, struct rect area)
{
    const struct rect t = film_cells(area, film->grid.side_px);
    struct rect all = {0, 0, 0, 0};
    for (int32_t row = t.y0; row < t.y1; row++)
        for (int32_t column = t.x0; column < t.x1; column++) {
            const struct rect own = shown_of_tile(film, film_tile_at(film, column, row), area);
            if (!rect_is_empty(own)) all = join(all, own);
        }
    return all;
}

int film_gather_shown(const struct film *film, uint32_t block, int32_t margin_px,
                      struct rect *shown, struct patch **out)
{
    assert(block < film->block_count && film->blocks[block].state == BLOCK_OUT);
    const struct rect area = film_block_rect(film, block);
    *out = NULL;
    *shown = find_shown(film, area);
    if (rect_is_empty(*shown)) return 0;
    const struct rect reach = film_reach(film, *shown);
    const struct rect read = rect_intersect(rect_grow(find_shown(film, reach), margin_px), reach);
    return gather(film, film_cells(read, film->grid.side_px), read, rect_grow(area, film->core_px),
                  out);
}

int film_gather_rect(const struct film *film, struct rect rect, struct patch **out)
{
    return gather(film, film_cells(rect, film->grid.side_px), rect, rect, out);
}
