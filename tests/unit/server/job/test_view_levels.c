/* The levels of a view: few pixels first, the document's own at last. */
#include "server/job/view_levels.h"
#include "tests/unit/unit.h"

static struct job job_of(int32_t width_px, int32_t height_px)
{
    return (struct job){.width_px = width_px,
                        .height_px = height_px,
                        .spp = 64,
                        .light_spp = 1,
                        .lens_extra = 9,
                        .tile_px = 64,
                        .indirect = INDIRECT_ADAPTIVE};
}

TEST(the_last_is_the_documents_own)
{
    struct job job = job_of(640, 360), last;
    assert_int_equal(view_levels(&job), 2);
    view_level_document(&job, 1, &last);
    assert_memory_equal(&job, &last, sizeof job);
    assert_int_equal(view_level_scale(&job, 1), 1);
}

TEST(the_first_is_small)
{
    static const int32_t sizes[][2] = {{640, 360},     {1, 16384},   {16384, 8192}, {129, 129},
                                       {11585, 11585}, {1920, 1080}, {4096, 5}};
    for (unsigned i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct job job = job_of(sizes[i][0], sizes[i][1]), first;
        view_level_document(&job, 0, &first);
        const int32_t scale = view_level_scale(&job, 0);
        assert_true((int64_t)first.width_px * first.height_px <= VIEW_FIRST_PIXELS);
        assert_in_range(first.width_px * scale, job.width_px, job.width_px + scale - 1);
        assert_in_range(first.height_px * scale, job.height_px, job.height_px + scale - 1);
    }
}

TEST(a_small_image_has_one_level)
{
    struct job job = job_of(128, 128), only;
    assert_int_equal(view_levels(&job), 1);
    view_level_document(&job, 0, &only);
    assert_memory_equal(&job, &only, sizeof job);
}

TEST(levels_become_finer)
{
    for (int32_t side = 1; side <= 11585; side += 97) {
        struct job job = job_of(side, side);
        const unsigned last = view_levels(&job) - 1;
        assert_true(last < VIEW_LEVELS_MAX);
        for (unsigned i = 0; i < last; i++)
            assert_true(view_level_scale(&job, i) > view_level_scale(&job, i + 1));
        assert_int_equal(view_level_scale(&job, last), 1);
    }
}

TEST(coarse_ones_have_few_samples_and_no_second_sets)
{
    struct job job = job_of(640, 360), first;
    view_level_document(&job, 0, &first);
    assert_int_equal(first.spp, VIEW_COARSE_SPP);
    assert_int_equal(first.light_spp, 1);
    assert_int_equal(first.indirect_spp, 0); /* as spp */
    assert_int_equal(first.lens_extra, 0);
    assert_int_equal(first.indirect, INDIRECT_AUTO);
    assert_int_equal(first.tile_px, VIEW_COARSE_TILE_PX);
}
