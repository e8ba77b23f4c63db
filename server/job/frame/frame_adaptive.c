/* The second set of rays of a frame, or of paths through its lens: each pixel's size of it is told
 * as blocks are drawn from the first, or of lenses how much it needs one, and dealt to the tiles
 * when all of them have been. */
#include <stdlib.h>
#include <string.h>

#include "proto/count_map.h"
#include "server/job/frame/frame_work.h"

int frame_adaptive_create(struct frame *f)
{
    struct frame_adaptive *r = &f->adaptive;
    const size_t area = (size_t)f->plan.width_px * (size_t)f->plan.height_px;
    bytes_writer_init(&r->packed);
    r->maps = plan_strata_maps(&f->plan);
    r->pixels = calloc(r->maps * area, sizeof *r->pixels);
    r->strata_maps = calloc(r->maps * area, sizeof *r->strata_maps);
    r->measured = calloc(film_block_count(f->film), sizeof *r->measured);
    r->tiles = calloc(tile_grid_count(&f->grid), sizeof *r->tiles);
    return r->pixels && r->strata_maps && r->measured && r->tiles ? 0 : ERR_MEMORY;
}

void frame_adaptive_destroy(struct frame *f)
{
    struct frame_adaptive *r = &f->adaptive;
    if (r->pixels) bytes_writer_fini(&r->packed);
    free(r->pixels);
    free(r->strata_maps);
    free(r->measured);
    free(r->tiles);
}

/* Returns where a rect's rows begin in a map of the whole image. */
static uint8_t *corner(const struct frame *f, uint32_t map, struct rect rect)
{
    const size_t stride = (size_t)f->plan.width_px, area = stride * (size_t)f->plan.height_px;
    return f->adaptive.pixels + map * area + (size_t)rect.y0 * stride + (size_t)rect.x0;
}

void frame_adaptive_keep(struct frame *f, uint32_t block, const uint8_t *strata_maps,
                         uint32_t measured)
{
    const struct rect rect = film_block_rect(f->film, block);
    const size_t width = (size_t)rect_width(rect);
    const uint8_t *from = strata_maps;
    for (uint32_t map = 0; map < f->adaptive.maps; map++) {
        uint8_t *to = corner(f, map, rect);
        for (int32_t y = rect.y0; y < rect.y1; y++, strata_maps += width, to += f->plan.width_px)
            memcpy(to, strata_maps, width);
    }
    const size_t count = f->adaptive.maps * (size_t)rect_area(rect);
    for (size_t i = 0; i < count; i++) f->adaptive.seen_rays += (double)from[i] * from[i];
    f->adaptive.seen_px += (double)rect_area(rect);
    f->adaptive.measured[block] = measured;
}

/* Gathers the pixels of a tile, map by map. */
static void gather(const struct frame *f, struct rect rect, uint8_t *strata_maps,
                   struct frame_adaptive_tile *tile)
{
    const size_t width = (size_t)rect_width(rect),
                 count = f->adaptive.maps * (size_t)rect_area(rect);
    uint8_t *to = strata_maps;
    *tile = (struct frame_adaptive_tile){.strata_maps = strata_maps};
    for (uint32_t map = 0; map < f->adaptive.maps; map++) {
        const uint8_t *from = corner(f, map, rect);
        for (int32_t y = rect.y0; y < rect.y1; y++, from += f->plan.width_px, to += width)
            memcpy(to, from, width);
    }
    for (size_t i = 0; i < count; i++) {
        tile->most = strata_maps[i] > tile->most ? strata_maps[i] : tile->most;
        tile->rays += (uint64_t)strata_maps[i] * strata_maps[i];
    }
}

static int pack(struct frame_adaptive *r, struct rect rect, struct frame_adaptive_tile *tile)
{
    tile->packed = r->packed.size_bytes;
    const int error =
        count_map_pack(&r->packed, tile->strata_maps, r->maps, rect_width(rect), rect_height(rect));
    tile->packed_bytes = (uint32_t)(r->packed.size_bytes - tile->packed);
    return error;
}

/* Returns the least level all of whose pixels, with those above, are no more than `most`; pixels of
 * the level below that still fit. */
static uint32_t find_level(const uint8_t *levels, size_t area, size_t most, size_t *rest,
                           size_t *next)
{
    size_t count[UINT8_MAX + 1] = {0}, all = 0;
    uint32_t level = UINT8_MAX + 1;
    for (size_t i = 0; i < area; i++) count[levels[i]]++;
    while (level > 1 && all + count[level - 1] <= most) all += count[--level];
    *rest = most - all;
    *next = level > 1 ? count[level - 1] : 0;
    return level;
}

/* Second sets go to the pixels that need them most; where too many need them alike, to some of
 * these, evenly spread along the rows. */
static void choose(const struct plan *plan, uint8_t *pixels)
{
    const size_t area = (size_t)plan->width_px * (size_t)plan->height_px;
    const size_t most = area * plan->lens_extra / (PLAN_LENS_EXTRA_STRATA * PLAN_LENS_EXTRA_STRATA);
    size_t rest, next, owed = 0;
    const uint32_t level = find_level(pixels, area, most, &rest, &next);
    for (size_t i = 0; i < area; i++) {
        bool chosen = pixels[i] >= level;
        if (next > 0 && pixels[i] == level - 1) {
            owed += rest;
            chosen = owed >= next;
            owed -= chosen ? next : 0;
        }
        pixels[i] = chosen ? PLAN_LENS_EXTRA_STRATA : 0;
    }
}

bool frame_adaptive_decide(struct frame *f, int *error)
{
    struct frame_adaptive *r = &f->adaptive;
    uint8_t *strata_maps = r->strata_maps;
    *error = 0;
    if (r->decided) return false;
    r->decided = true;
    if (f->plan.lens_extra > 0) choose(&f->plan, r->pixels);
    for (uint32_t i = 0; i < tile_grid_count(&f->grid) && !*error; i++) {
        const struct rect rect = tile_grid_rect(&f->grid, i);
        gather(f, rect, strata_maps, &r->tiles[i]);
        strata_maps += r->maps * (size_t)rect_area(rect);
        f->rounds.more_passes[i] = r->tiles[i].most > 0;
        r->rays += r->tiles[i].rays;
        if (r->tiles[i].most > 0) *error = pack(r, rect, &r->tiles[i]);
    }
    return !*error && r->rays > 0;
}

void frame_adaptive_count(struct frame *f)
{
    const uint32_t l = f->plan.indirect_strata_per_axis;
    uint64_t sets = 0;
    frame_costs_foresee(f);
    if (f->plan.lens_extra > 0) {
        f->statistics.lens_second_paths = f->adaptive.rays;
        return;
    }
    for (uint32_t i = 0; i < film_block_count(f->film); i++) sets += f->adaptive.measured[i];
    f->statistics.adaptive_first_rays = sets * l * l;
    f->statistics.adaptive_second_rays = f->adaptive.rays;
}

struct plan_pass frame_adaptive_pass(const struct frame *f, uint32_t tile, uint32_t number)
{
    const struct frame_adaptive_tile *t = &f->adaptive.tiles[tile];
    if (number < plan_pass_count(&f->plan)) return plan_scheduled_pass(&f->plan, number);
    struct plan_pass pass = {.number = number, .strata = t->most, .strata_map = t->strata_maps};
    if (f->adaptive.maps > 1)
        pass.lobes = t->strata_maps + rect_area(tile_grid_rect(&f->grid, tile));
    return pass;
}
