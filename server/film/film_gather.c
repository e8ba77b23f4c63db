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

int film_gather_rect(const struct film *film, struct rect rect, struct patch **out)
{
    return gather(film, film_cells(rect, film->grid.side_px), rect, rect, out);
}
