#include "tests/unit/server/reconstruct/film_picture.h"

#include "tests/unit/unit.h"

struct samples *picture_tile(const struct plan *plan, uint32_t tile, put_pixel_fn *put,
                             const void *ctx)
{
    struct tile_grid grid;
    struct samples_layout layout;
    struct samples *s;
    if (tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px)) return NULL;
    const struct rect r = tile_grid_rect(&grid, tile);
    if (samples_layout_init(&layout, plan, 0, rect_width(r), rect_height(r))) return NULL;
    if (samples_create(&layout, &s)) return NULL;
    size_t i = 0;
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++) put(s, plan, x, y, i++, ctx);
    return s;
}

struct film *picture_film(const struct plan *plan, int32_t block_px, int32_t more_px)
{
    struct film *film;
    const int32_t core_px = block_core_px(plan), halo_px = block_halo_px(plan) + more_px;
    assert_int_equal(film_create(plan, block_px, core_px, halo_px, &film), 0);
    return film;
}

static uint32_t tile_count(const struct plan *plan)
{
    struct tile_grid grid;
    assert_int_equal(tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px), 0);
    return tile_grid_count(&grid);
}

void picture_land(const struct plan *plan, struct film *film, tile_fn *make, const void *ctx)
{
    for (uint32_t t = 0; t < tile_count(plan); t++)
        assert_int_equal(film_land(film, t, 0, make(plan, t, ctx)), 0);
}

void picture_land_pixels(const struct plan *plan, struct film *film, put_pixel_fn *put,
                         const void *ctx)
{
    for (uint32_t t = 0; t < tile_count(plan); t++)
        assert_int_equal(film_land(film, t, 0, picture_tile(plan, t, put, ctx)), 0);
}

static void add_statistics(const struct block_statistics *one, struct block_statistics *sum)
{
    sum->sub_samples_unmatched += one->sub_samples_unmatched;
    sum->sub_samples_lone += one->sub_samples_lone;
    sum->pixels_background += one->pixels_background;
    sum->shadow.pixels_filtered += one->shadow.pixels_filtered;
    sum->shadow.pixels_alone += one->shadow.pixels_alone;
    sum->shadow.pixels_unlit += one->shadow.pixels_unlit;
    sum->shadow.blocks_skipped += one->shadow.blocks_skipped;
    sum->shadow_cpu_us += one->shadow_cpu_us;
    sum->indirect.pixels_filtered += one->indirect.pixels_filtered;
    sum->indirect.pixels_skipped += one->indirect.pixels_skipped;
    sum->indirect.blocks_skipped += one->indirect.blocks_skipped;
    sum->indirect_cpu_us += one->indirect_cpu_us;
    sum->lens.pixels_filtered += one->lens.pixels_filtered;
    sum->lens_relight.samples_lit += one->lens_relight.samples_lit;
    sum->lens_relight.samples_own += one->lens_relight.samples_own;
    sum->lens_cpu_us += one->lens_cpu_us;
}

void picture_draw(const struct plan *plan, struct film *film, struct image *image,
                  struct block_statistics *sum)
{
    uint32_t block;
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        struct block_statistics one;
        const struct rect rect = film_block_rect(film, block);
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_int_equal(block_reconstruct(plan, patch, rect, image, &one), 0);
        patch_destroy(&patch);
        if (film_block_done(film, block) && sum) add_statistics(&one, sum);
    }
}

const float *picture_channel(const struct image *image, const char *channel)
{
    const struct plane *plane = image_plane(image, channel);
    assert_non_null(plane);
    return plane->data;
}

float picture_at(const struct image *image, const char *channel, int32_t x, int32_t y)
{
    return *plane_at(image_plane(image, channel), x, y);
}
