/* Blocks that are kept for all readers of a layer: how much of them is, and that it is given back.
 */
#include "proto/error.h"
#include "proto/job/job.h"
#include "server/stream/block_cache.h"
#include "tests/unit/unit.h"

enum { WIDTH = 130, HEIGHT = 70, BLOCKS = 3 * 2 };

static struct image *image;
static struct pixel_changes changes;
static const struct rect first = {0, 0, 64, 64}, second = {64, 0, 128, 64};
static const size_t whole_bytes = PIXELS_HEADER_BYTES + (size_t)64 * 64 * 3 * 2; /* a first block */

static int begin(void **state)
{
    (void)state;
    assert_int_equal(image_create(LAYER_BEAUTY, WIDTH, HEIGHT, &image), 0);
    assert_int_equal(pixel_changes_init(&changes, WIDTH, HEIGHT), 0);
    pixel_changes_mark(&changes, (struct rect){0, 0, WIDTH, HEIGHT}, 1);
    return 0;
}

static int end(void **state)
{
    (void)state;
    pixel_changes_fini(&changes);
    image_destroy(&image);
    return 0;
}

EACH_TEST(begin, end);

static struct block_cache *cache_of_two(struct block_cache **list, struct pixel_budget *budget)
{
    struct block_cache *cache = block_cache_join(list, budget, "beauty", PIXELS_F16);
    assert_non_null(cache);
    assert_ptr_equal(block_cache_join(list, budget, "beauty", PIXELS_F16), cache);
    return cache;
}

static void leave(struct block_cache **list, struct block_cache *cache)
{
    struct block_cache *one = cache, *two = cache;
    block_cache_leave(list, &one);
    block_cache_leave(list, &two);
    assert_null(*list);
}

static void ask(struct block_cache *cache, struct rect rect)
{
    struct pixel_block *block = block_cache_block(cache, image, &changes, rect);
    assert_non_null(block);
    assert_true(block->size_bytes <= whole_bytes);
    pixel_block_unref(&block);
}

TEST(beyond_the_budget_each_reader_makes_its_own)
{
    struct pixel_budget budget = {.shared_max_bytes = whole_bytes, .most_bytes = whole_bytes};
    struct block_cache *list = NULL, *cache = cache_of_two(&list, &budget);
    for (int i = 0; i < 2; i++) ask(cache, first);
    assert_int_equal(cache->made, 1);
    assert_int_equal(budget.kept_bytes, whole_bytes);
    for (int i = 0; i < 2; i++) ask(cache, second);
    assert_int_equal(cache->made, 3);
    assert_int_equal(budget.kept_bytes, whole_bytes);
    /* What changes takes the place of what was there. */
    pixel_changes_mark(&changes, first, 2);
    for (int i = 0; i < 2; i++) ask(cache, first);
    assert_int_equal(cache->made, 4);
    assert_int_equal(budget.kept_bytes, whole_bytes);
    block_cache_clear(cache);
    assert_int_equal(budget.kept_bytes, 0);
    for (int i = 0; i < 2; i++) ask(cache, second);
    assert_int_equal(cache->made, 5);
    leave(&list, cache);
    assert_int_equal(budget.kept_bytes, 0);
}

TEST(caches_share_the_budget)
{
    struct pixel_budget budget = {.shared_max_bytes = whole_bytes, .most_bytes = whole_bytes};
    struct block_cache *lists[2] = {NULL}, *caches[2];
    for (int i = 0; i < 2; i++) caches[i] = cache_of_two(&lists[i], &budget);
    ask(caches[0], first);
    for (int i = 0; i < 2; i++) ask(caches[1], first);
    assert_int_equal(caches[1]->made, 2);
    leave(&lists[0], caches[0]);
    for (int i = 0; i < 2; i++) ask(caches[1], first);
    assert_int_equal(caches[1]->made, 3);
    leave(&lists[1], caches[1]);
    assert_int_equal(budget.kept_bytes, 0);
}

static int keep_all(struct block_cache *cache, size_t room_bytes)
{
    struct pixel_blocks wanted;
    assert_int_equal(pixel_blocks_init(&wanted, WIDTH, HEIGHT), 0);
    pixel_blocks_mark(&wanted, (struct rect){0, 0, WIDTH, HEIGHT});
    int error = block_cache_keep(cache, image, &changes, &wanted, &room_bytes);
    pixel_blocks_fini(&wanted);
    return error;
}

TEST(what_outlasts_a_picture_is_in_the_budget)
{
    struct pixel_budget budget = {.most_bytes = BLOCKS * whole_bytes};
    struct block_cache *list = NULL, *cache = cache_of_two(&list, &budget);
    ask(cache, first);
    assert_int_equal(budget.kept_bytes, 0); /* nothing while the picture is in work */
    assert_int_equal(keep_all(cache, SIZE_MAX), 0);
    assert_in_range(budget.kept_bytes, whole_bytes, BLOCKS * whole_bytes);
    struct pixel_block *block = block_cache_block(cache, NULL, &changes, second);
    assert_non_null(block);
    pixel_block_unref(&block);
    block_cache_clear(cache);
    assert_int_equal(budget.kept_bytes, 0);
    budget.most_bytes = 2 * whole_bytes - 1;
    assert_int_equal(keep_all(cache, SIZE_MAX), ERR_LIMIT);
    assert_true(budget.kept_bytes <= budget.most_bytes);
    block_cache_clear(cache);
    budget.most_bytes = BLOCKS * whole_bytes;
    assert_int_equal(keep_all(cache, 2 * whole_bytes - 1), ERR_LIMIT);
    leave(&list, cache);
    assert_int_equal(budget.kept_bytes, 0);
}
