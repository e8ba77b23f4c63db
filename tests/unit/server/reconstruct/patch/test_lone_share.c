/* Light of lone sub-samples on its way from tiles' lists to pixels. */
#include <math.h>
#include <stdlib.h>

#include "proto/job/job.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/synthetic.h"
#include "tests/unit/unit.h"

#define LAYERS (LAYER_BEAUTY | LAYER_DIRECT | LAYER_INDIRECT)

enum { WIDTH = 45, HEIGHT = 29, TILE_PX = 16, SUBS = 3 };

static void lone_plan(struct plan *plan)
{
    synthetic_plan(plan, WIDTH, HEIGHT, TILE_PX);
    plan->planes |= PLANE_BIT(LONE);
}

/* Far in front of all that is around, of an object of its own. */
static bool is_lone(int32_t x, int32_t y, uint32_t k)
{
    return (x * 7 + y * 13 + (int32_t)k * 5) % 23 == 0;
}

/* A number for each entry's channels. */
static float light_of(int32_t x, int32_t y, uint32_t k, uint32_t part, uint32_t c)
{
    return 0.125f * (float)(1 + (x * 3 + y * 5 + (int32_t)(k * 7 + part * 11 + c)) % 61);
}

/* The tile, with lone sub-samples and `scale` times their light; 0: without it. */
static struct samples *tile_of(const struct plan *plan, uint32_t index, const void *ctx)
{
    const float scale = *(const float *)ctx;
    struct tile_grid grid;
    struct samples *s = synthetic_tile(plan, index);
    uint32_t places[TILE_PX * TILE_PX * SUBS], count = 0;
    tile_grid_init(&grid, WIDTH, HEIGHT, TILE_PX);
    const struct rect r = tile_grid_rect(&grid, index);
    const uint32_t width = (uint32_t)rect_width(r), area = (uint32_t)rect_area(r);
    for (uint32_t place = 0; place < area * SUBS; place++) {
        const uint32_t i = place / SUBS, k = place % SUBS;
        if (!is_lone(r.x0 + (int32_t)(i % width), r.y0 + (int32_t)(i / width), k)) continue;
        samples_u16(s, PLANE_SUB_DEPTH, k)[i] = half_from_float(-0.9f);
        samples_u16(s, PLANE_SUB_ID, k)[i] = 65000;
        places[count++] = place;
    }
    if (scale == 0.0f || count == 0) return s;
    assert_int_equal(lone_create(s->layout.lone_parts, count, &s->lone), 0);
    for (uint32_t e = 0; e < count; e++) {
        const uint32_t i = places[e] / SUBS, k = places[e] % SUBS;
        s->lone->words[e] = places[e];
        for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
            for (uint32_t c = 0; c < 3; c++) {
                float *light = lone_values(s->lone, part, c);
                if (light)
                    light[e] = scale * light_of(r.x0 + (int32_t)(i % width),
                                                r.y0 + (int32_t)(i / width), k, part, c);
            }
    }
    return s;
}

static struct film *film_of(const struct plan *plan, int32_t block_px, float scale)
{
    struct film *film = picture_film(plan, block_px, 0);
    picture_land(plan, film, tile_of, &scale);
    return film;
}

static struct image *render(const struct plan *plan, int32_t block_px, float scale,
                            struct block_statistics *sum)
{
    struct film *film = film_of(plan, block_px, scale);
    struct scratch *scratch;
    struct image *image;
    assert_int_equal(scratch_create(&scratch), 0);
    film_gather_in(film, scratch);
    assert_int_equal(image_create(LAYERS, WIDTH, HEIGHT, &image), 0);
    *sum = (struct block_statistics){0};
    picture_draw(plan, film, image, sum);
    film_destroy(&film);
    scratch_destroy(&scratch); /* everything was given back */
    return image;
}

static uint32_t count_lone(void)
{
    uint32_t count = 0;
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++)
            for (uint32_t k = 0; k < SUBS; k++) count += is_lone(x, y, k);
    return count;
}

TEST(patches_have_the_entries_of_their_core)
{
    struct plan plan;
    uint32_t block;
    lone_plan(&plan);
    struct film *film = film_of(&plan, 20, 1);
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        assert_int_equal(film_gather(film, block, &patch), 0);
        const struct rect r = patch->rect, core = patch->core;
        for (int32_t y = r.y0; y < r.y1; y++)
            for (int32_t x = r.x0; x < r.x1; x++)
                for (uint32_t k = 0; k < SUBS; k++) {
                    const bool in = x >= core.x0 && x < core.x1 && y >= core.y0 && y < core.y1;
                    const struct lone_entry *e =
                        lone_share_find(&patch->lone, patch_pixel(patch, x, y) * SUBS + k);
                    assert_true((e != NULL) == (in && is_lone(x, y, k)));
                    if (!e) continue;
                    assert_true(e->light[LONE_DIRECT][1] == light_of(x, y, k, LONE_DIRECT, 1));
                    assert_true(e->light[LONE_INDIRECT][2] == light_of(x, y, k, LONE_INDIRECT, 2));
                    assert_true(e->light[LONE_GLOSSY][0] == 0.0f); /* not planned */
                }
        patch_destroy(&patch);
        film_block_done(film, block);
    }
    film_destroy(&film);
}

/* What a listed sub-sample sends is its own albedo times its own light, whatever is around it: two
 * lists that differ in one part change the picture by just that. */
TEST(pixels_take_their_own_light)
{
    struct plan plan;
    struct block_statistics lit, unlit;
    lone_plan(&plan);
    struct image *with = render(&plan, 16, 1, &lit);
    struct image *without = render(&plan, 16, 0, &unlit);
    assert_int_equal(lit.sub_samples_lone, count_lone());
    assert_true(lit.sub_samples_unmatched < unlit.sub_samples_unmatched);
    assert_int_equal(unlit.sub_samples_lone, 0);
    uint32_t compared = 0;
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            uint32_t lone = 0;
            for (uint32_t k = 0; k < SUBS; k++) lone += is_lone(x, y, k);
            const float *a = plane_at(image_plane(with, "direct.R"), x, y);
            const float *b = plane_at(image_plane(without, "direct.R"), x, y);
            if (lone == 0) assert_true(*a == *b);
            compared += lone > 0 && *a != *b;
        }
    assert_true(compared > 50);
    image_destroy(&with);
    image_destroy(&without);
}

/* A pixel's number less that of the other picture. */
static float more(const struct image *a, const struct image *b, const char *channel, int32_t x,
                  int32_t y)
{
    return *plane_at(image_plane(a, channel), x, y) - *plane_at(image_plane(b, channel), x, y);
}

/* With twice the light, pixels have just that much more: each sub-sample's own times its albedo. */
TEST(layers_are_sums)
{
    static const char *const direct[] = {"direct.R", "direct.G", "direct.B"};
    static const char *const indirect[] = {"indirect.R", "indirect.G", "indirect.B"};
    static const char *const beauty[] = {"R", "G", "B"};
    struct plan plan;
    struct block_statistics sum;
    struct patch *patch;
    uint32_t block;
    lone_plan(&plan);
    struct image *once = render(&plan, 16, 1, &sum), *twice = render(&plan, 16, 2, &sum);
    struct film *film = film_of(&plan, 64, 1);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++)
            for (uint32_t c = 0; c < 3; c++) {
                float d = 0, i = 0;
                for (uint32_t k = 0; k < SUBS; k++) {
                    const float albedo = patch->sub_albedo[k][c][patch_pixel(patch, x, y)];
                    if (!is_lone(x, y, k)) continue;
                    d += albedo / (1 + SUBS) * light_of(x, y, k, LONE_DIRECT, c);
                    i += albedo / (1 + SUBS) * light_of(x, y, k, LONE_INDIRECT, c);
                }
                assert_true(fabsf(more(twice, once, direct[c], x, y) - d) < 1e-4f);
                assert_true(fabsf(more(twice, once, indirect[c], x, y) - i) < 1e-4f);
                assert_true(fabsf(more(twice, once, beauty[c], x, y) - d - i) < 2e-4f);
            }
    patch_destroy(&patch);
    film_block_done(film, block);
    film_destroy(&film);
    image_destroy(&once);
    image_destroy(&twice);
}

TEST(blocks_do_not_matter)
{
    static const int32_t sides[] = {7, 16, 33};
    struct plan plan;
    struct block_statistics sum;
    lone_plan(&plan);
    struct image *whole = render(&plan, 64, 1, &sum);
    for (size_t n = 0; n < sizeof sides / sizeof sides[0]; n++) {
        struct image *cut = render(&plan, sides[n], 1, &sum);
        assert_int_equal(sum.sub_samples_lone, count_lone());
        assert_memory_equal(cut->data, whole->data,
                            whole->channel_count * WIDTH * HEIGHT * sizeof(float));
        image_destroy(&cut);
    }
    image_destroy(&whole);
}

TEST(films_count_lists)
{
    struct plan plan;
    lone_plan(&plan);
    struct film *with = film_of(&plan, 16, 1), *without = film_of(&plan, 16, 0);
    assert_int_equal(film_bytes(with),
                     film_bytes(without) + count_lone() * 4 * lone_words(lone_parts(&plan)));
    film_destroy(&with);
    film_destroy(&without);
}

TEST(entries_are_found)
{
    struct lone_entry entries[] = {{.place = 9}, {.place = 2}, {.place = 700}, {.place = 30}};
    struct lone_share share = {
        .parts = 1u << LONE_INDIRECT | 1u << LONE_INDIRECT_HALF, .count = 4, .entries = entries};
    const struct lone_share none = {.count = 0};
    lone_share_sort(&share);
    for (uint32_t e = 0; e < 4; e++)
        assert_ptr_equal(lone_share_find(&share, entries[e].place), &entries[e]);
    static const size_t others[] = {0, 1, 3, 10, 31, 699, 701, SIZE_MAX};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        assert_null(lone_share_find(&share, others[i]));
    assert_null(lone_share_find(&none, 0));
    entries[0].light[LONE_INDIRECT][1] = 2.0f;
    entries[0].light[LONE_INDIRECT_HALF][1] = 2.5f;
    assert_true(lone_entry_error(&share, entries, LONE_INDIRECT, LONE_INDIRECT_HALF, 1) == 0.5f);
    assert_true(lone_entry_error(&share, entries, LONE_GLOSSY, LONE_GLOSSY_HALF, 1) == 0.0f);
}
