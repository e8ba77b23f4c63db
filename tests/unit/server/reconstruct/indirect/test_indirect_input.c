/* Odd input of the axis-aligned filters of indirect light: pictures of one pixel, all that a film
 * can hold, and what is refused. */
#include "tests/random.h"
#include "tests/unit/server/reconstruct/indirect/indirect_picture.h"
#include "tests/unit/unit.h"

/* One pixel, one row, one column; nothing met anywhere, everything met at once. */
TEST(small_pictures)
{
    static const int32_t sizes[][2] = {{1, 1}, {1, 700}, {700, 1}, {3, 2}, {17, 33}};
    static const float reflectors[] = {0.0f, 1e-30f, 1.0f, BOUNCE_DISTANCE_NONE * 2.0f};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        for (size_t r = 0; r < 4; r++) {
            struct plan plan;
            struct patch *patch = plane_patch(&plan, sizes[s][0], sizes[s][1], 3.0f, reflectors[r]);
            const size_t area = (size_t)rect_area(patch->rect);
            for (size_t f = 0; f < FILTERS; f++) {
                struct picture picture;
                plan.indirect_filter = filters[f];
                picture_init(&picture, patch);
                filter_blocks(&plan, patch, patch->rect, 1024, &picture);
                for (size_t i = 0; i < area; i++) {
                    const float v = picture.channel[0][i];
                    assert_true(r == 0 ? v == 0.0f : v > 0.3f && v < 6.0f);
                    assert_true((picture.width[i] > 0.0f) == (r != 0));
                }
                assert_int_equal(picture.statistics.blocks_skipped, r == 0);
                assert_int_equal(picture.statistics.pixels_skipped, r == 0 ? area : 0);
                picture_fini(&picture);
            }
            patch_destroy(&patch);
        }
    }
}

static float wild(struct random *r, float least, float most)
{
    return least * powf(most / least, random_unit(r));
}

/* Whatever a film can hold comes out finite and not negative. */
TEST(all_stays_finite)
{
    struct random r = {5};
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 60, 50, 3.0f, 1.0f);
    for (int turn = 0; turn < 4; turn++) {
        const float spread = turn == 0 ? 1.01f : turn == 1 ? 1e3f : 1e20f;
        plan.mu = turn == 3 ? 100.0f : 1.0f;
        for (size_t i = 0; i < 60 * 50; i++) {
            const bool empty = random_unit(&r) < 0.1f;
            patch->depth[i] = empty ? 0.0f : fminf(wild(&r, 1.0f, spread) * 1e-4f, 1e16f);
            patch->id[i] = empty ? 0 : (uint32_t)(random_bits(&r) % 3) + UINT32_MAX - 3;
            patch->bounce_distance_min[i] =
                empty || random_unit(&r) < 0.1f ? 0.0f : wild(&r, 1e-20f, 1e20f);
            for (int k = 0; k < 3; k++) {
                patch->indirect[k][i] = random_unit(&r) < 0.3f ? 0.0f : wild(&r, 1e-20f, 1e16f);
                if (empty) patch->normal[k][i] = 0.0f;
            }
        }
        for (size_t f = 0; f < FILTERS; f++) {
            struct picture picture;
            plan.indirect_filter = filters[f];
            picture_init(&picture, patch);
            filter_blocks(&plan, patch, patch->rect, 64, &picture);
            for (size_t i = 0; i < 60 * 50; i++) {
                assert_true(isfinite(picture.width[i]));
                for (int c = 0; c < 3; c++)
                    assert_true(picture.channel[c][i] >= 0.0f && isfinite(picture.channel[c][i]));
            }
            picture_fini(&picture);
        }
    }
    patch_destroy(&patch);
}

TEST(refuses)
{
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 20, 10, 3.0f, 1.0f);
    struct indirect_statistics statistics = {0};
    struct picture p;
    picture_init(&p, patch);
    const float *const in[3] = {patch->indirect[0], patch->indirect[1], patch->indirect[2]};
    const struct rect all = patch->rect, outside = {0, 0, 21, 10}, empty = {3, 3, 3, 5};
    assert_int_equal(indirect_filter(&plan, patch, outside, 3, in, p.channel, NULL, &statistics),
                     ERR_RANGE);
    assert_int_equal(indirect_filter(&plan, patch, empty, 3, in, p.channel, NULL, &statistics),
                     ERR_RANGE);
    assert_int_equal(indirect_filter(&plan, patch, all, INDIRECT_CHANNELS_MAX + 1, in, p.channel,
                                     NULL, &statistics),
                     ERR_RANGE);
    static const uint32_t not_these[] = {INDIRECT_FILTER_SHEARED + 1, 99};
    for (int i = 0; i < 2; i++) {
        plan.indirect_filter = not_these[i];
        assert_int_equal(indirect_filter(&plan, patch, all, 3, in, p.channel, NULL, &statistics),
                         ERR_RANGE);
    }
    assert_int_equal(statistics.pixels_filtered + statistics.pixels_skipped, 0);
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    assert_int_equal(indirect_filter(&plan, patch, all, 3, in, p.channel, NULL, &statistics), 0);
    picture_fini(&p);
    patch_destroy(&patch);
}
