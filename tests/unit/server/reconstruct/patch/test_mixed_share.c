/* Entries of mixed pixels on their way from tiles' lists to pixels. */
#include <math.h>

#include "proto/job/job.h"
#include "server/film/film.h"
#include "server/image/image.h"
#include "server/reconstruct/block.h"
#include "tests/unit/server/reconstruct/synthetic.h"
#include "tests/unit/unit.h"

#define LAYERS (LAYER_BEAUTY | LAYER_DIRECT | LAYER_INDIRECT | LAYER_ALBEDO)

enum { WIDTH = 45, HEIGHT = 29, TILE_PX = 16 };

static void mixed_plan(struct plan *plan)
{
    synthetic_plan(plan, WIDTH, HEIGHT, TILE_PX);
    plan->planes |= PLANE_BIT(MIXED);
}

static bool is_mixed(int32_t x, int32_t y)
{
    return (x * 7 + y * 13) % 5 == 0;
}

/* Only such as lie in the image lend, and pixels lend a part each. */
static bool is_lender(int32_t x, int32_t y, uint32_t slot)
{
    const int32_t px = x + (int32_t)(slot % 3) - 1, py = y + (int32_t)(slot / 3) - 1;
    if (slot == MIXED_SLOT_OWN) return true;
    return px >= 0 && py >= 0 && px < WIDTH && py < HEIGHT && (x + y + (int32_t)slot) % 3 == 0;
}

static float value_of(int32_t x, int32_t y, uint32_t slot, uint32_t value)
{
    return (float)((x * 3 + y * 5 + (int32_t)(slot * 7 + value * 11)) % 13) / 128.0f;
}

/* The tile's mixed pixels, all or none; `outside`: their lenders may be outside the image, too. */
static struct samples *tile_of(const struct plan *plan, uint32_t index, bool mixed, bool outside)
{
    struct tile_grid grid;
    struct samples *s = synthetic_tile(plan, index);
    uint32_t places[TILE_PX * TILE_PX * MIXED_SLOTS], count = 0;
    tile_grid_init(&grid, WIDTH, HEIGHT, TILE_PX);
    const struct rect r = tile_grid_rect(&grid, index);
    const uint32_t width = (uint32_t)rect_width(r), area = (uint32_t)rect_area(r);
    for (uint32_t place = 0; place < area * MIXED_SLOTS; place++) {
        const uint32_t i = place / MIXED_SLOTS, slot = place % MIXED_SLOTS;
        const int32_t x = r.x0 + (int32_t)(i % width), y = r.y0 + (int32_t)(i / width);
        const bool edge = x == 0 || y == 0 || x == WIDTH - 1 || y == HEIGHT - 1;
        if (is_mixed(x, y) && (is_lender(x, y, slot) || (outside && edge))) places[count++] = place;
    }
    if (!mixed || count == 0) return s;
    assert_int_equal(sparse_list_create(s->layout.mixed_values, count, &s->mixed), 0);
    for (uint32_t e = 0; e < count; e++) {
        const uint32_t i = places[e] / MIXED_SLOTS, slot = places[e] % MIXED_SLOTS;
        s->mixed->words[e] = places[e];
        for (uint32_t v = 0; v < s->mixed->values; v++)
            sparse_list_numbers(s->mixed, v)[e] =
                value_of(r.x0 + (int32_t)(i % width), r.y0 + (int32_t)(i / width), slot, v);
    }
    return s;
}

static struct image *render(const struct plan *plan, int32_t block_px, bool mixed, bool outside,
                            struct block_statistics *sum)
{
    struct film *film;
    struct tile_grid grid;
    struct scratch *scratch;
    struct image *image;
    uint32_t block;
    tile_grid_init(&grid, WIDTH, HEIGHT, TILE_PX);
    assert_int_equal(film_create(plan, block_px, block_core_px(plan), block_halo_px(plan), &film),
                     0);
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++)
        assert_int_equal(film_land(film, t, 0, tile_of(plan, t, mixed, outside)), 0);
    assert_int_equal(scratch_create(&scratch), 0);
    film_gather_in(film, scratch);
    assert_int_equal(image_create(LAYERS, WIDTH, HEIGHT, &image), 0);
    *sum = (struct block_statistics){0};
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        struct block_statistics one;
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_int_equal(block_reconstruct(plan, patch, film_block_rect(film, block), image, &one),
                         0);
        patch_destroy(&patch);
        film_block_done(film, block);
        sum->pixels_mixed += one.pixels_mixed;
    }
    film_destroy(&film);
    scratch_destroy(&scratch); /* everything was given back */
    return image;
}

static uint32_t count_mixed(void)
{
    uint32_t count = 0;
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) count += is_mixed(x, y);
    return count;
}

static float at(const struct image *image, const char *channel, int32_t x, int32_t y)
{
    return *plane_at(image_plane(image, channel), x, y);
}

/* Albedo is the sum of entries, coverage that of shares; what is not listed stays as it was. */
TEST(pixels_take_their_entries)
{
    struct plan plan;
    struct block_statistics sum, none;
    mixed_plan(&plan);
    struct image *with = render(&plan, 16, true, false, &sum);
    struct image *without = render(&plan, 16, false, false, &none);
    assert_int_equal(sum.pixels_mixed, count_mixed());
    assert_int_equal(none.pixels_mixed, 0);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            float share = 0.0f, albedo = 0.0f;
            if (!is_mixed(x, y)) {
                assert_true(at(with, "R", x, y) == at(without, "R", x, y));
                continue;
            }
            for (uint32_t slot = 0; slot < MIXED_SLOTS; slot++) {
                if (!is_lender(x, y, slot)) continue;
                share += value_of(x, y, slot, MIXED_SHARE);
                albedo += value_of(x, y, slot, MIXED_ALBEDO + 1);
            }
            assert_true(fabsf(at(with, "A", x, y) - share) < 1e-6f);
            assert_true(fabsf(at(with, "albedo.G", x, y) - albedo) < 1e-6f);
            assert_true(fabsf(at(with, "direct.G", x, y) + at(with, "indirect.G", x, y) -
                              at(with, "G", x, y)) < 1e-5f);
        }
    image_destroy(&with);
    image_destroy(&without);
}

TEST(blocks_do_not_matter)
{
    static const int32_t sides[] = {7, 16, 33};
    struct plan plan;
    struct block_statistics sum;
    mixed_plan(&plan);
    struct image *whole = render(&plan, 64, true, false, &sum);
    for (size_t n = 0; n < sizeof sides / sizeof sides[0]; n++) {
        struct image *cut = render(&plan, sides[n], true, false, &sum);
        assert_int_equal(sum.pixels_mixed, count_mixed());
        assert_memory_equal(cut->data, whole->data,
                            whole->channel_count * WIDTH * HEIGHT * sizeof(float));
        image_destroy(&cut);
    }
    image_destroy(&whole);
}

/* A worker may say what it likes: nothing outside the image is read. */
TEST(lenders_outside_the_image_are_left_out)
{
    struct plan plan;
    struct block_statistics sum;
    mixed_plan(&plan);
    struct image *image = render(&plan, 16, true, true, &sum);
    assert_int_equal(sum.pixels_mixed, count_mixed());
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) assert_true(isfinite(at(image, "R", x, y)));
    image_destroy(&image);
}

TEST(entries_are_found)
{
    struct mixed_entry entries[] = {
        {.place = 9 * 4 + 4}, {.place = 9 * 1 + 8}, {.place = 9 * 7 + 2}, {.place = 9 * 4 + 1}};
    struct mixed_share share = {.count = 4, .entries = entries};
    const struct mixed_share none = {.count = 0};
    static const uint32_t from[] = {0, 0, 1, 1, 1, 3, 3, 3, 4};
    static const uint32_t found[] = {4, 0, 4, 4, 1, 4, 4, 3, 4};
    uint32_t first[9];
    mixed_share_sort(&share, 9);
    for (size_t pixel = 0; pixel < 9; pixel++)
        assert_int_equal(mixed_share_find(&share, pixel), found[pixel]);
    share.first = first;
    mixed_share_sort(&share, 9);
    for (size_t pixel = 0; pixel < 9; pixel++)
        assert_int_equal(mixed_share_find(&share, pixel), found[pixel]);
    for (size_t pixel = 0; pixel < sizeof from / sizeof from[0]; pixel++)
        assert_int_equal(mixed_share_from(&share, pixel), from[pixel]);
    assert_int_equal(mixed_share_from(&none, 3), 0);
}
