/* Lens samples and paths: the same picture, and, where a plan has both, the same paths. */
#include <stdlib.h>

#include "tests/unit/worker/trace/field/lens_room.h"

/* Sums of the channels over the picture, each seed a term; mean and variance of the mean. */
static void picture_of_seeds(bool lens, double mean[3], double variance[3])
{
    enum { SEEDS = 48 };
    double sum[3] = {0}, squares[3] = {0};
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(16, 2);
    add_room(f, &p);
    if (!lens) {
        p.planes = PLANE_BIT(PATH_RADIANCE);
        p.lens_strata_per_axis = 0;
        p.paths.spp = 4;
    }
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        p.pattern.seed = seed;
        struct traced t = trace_all(f, &p);
        for (uint32_t c = 0; c < 3; c++) {
            double all = 0;
            for (size_t i = 0; i < 256; i++)
                for (uint32_t k = 0; k < 4; k++)
                    all += lens ? (double)value(&t, PLANE_LENS_RADIANCE, k * 3 + c, i)
                                : (double)samples_f32(t.samples, PLANE_PATH_RADIANCE, c)[i] / 4;
            sum[c] += all;
            squares[c] += all * all;
        }
        traced_fini(&t);
    }
    for (int c = 0; c < 3; c++) {
        mean[c] = sum[c] / SEEDS;
        variance[c] = (squares[c] / SEEDS - mean[c] * mean[c]) / (SEEDS - 1);
    }
    free(f);
}

TEST(pictures_are_those_of_paths)
{
    double lens[3], paths[3], lens_variance[3], paths_variance[3];
    picture_of_seeds(true, lens, lens_variance);
    picture_of_seeds(false, paths, paths_variance);
    for (int c = 0; c < 3; c++) {
        const double off = lens[c] - paths[c];
        assert_true(paths[c] > 100);
        assert_true(off * off < 16 * (lens_variance[c] + paths_variance[c]));
        assert_true(lens_variance[c] < 4e-4 * lens[c] * lens[c]); /* else it tells nothing */
    }
}

/* Where the plan has paths these are the lens's: sums of what its samples bring. */
TEST(paths_are_the_samples)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(16, 3);
    p.planes &= ~PLANES_LENS_SURFACE;
    add_room(f, &p);
    struct traced alone = trace_all(f, &p);
    p.planes |= PLANES_RESIDUAL_READ;
    p.paths.spp = 9;
    struct traced both = trace_all(f, &p);
    float seen = 0;
    for (size_t i = 0; i < 256; i++) {
        for (uint32_t c = 0; c < 3; c++) {
            float sum = 0;
            for (uint32_t k = 0; k < 9; k++) {
                const float light = value(&both, PLANE_LENS_RADIANCE, k * 3 + c, i);
                assert_true(light == value(&alone, PLANE_LENS_RADIANCE, k * 3 + c, i));
                sum += light;
            }
            assert_true(samples_f32(both.samples, PLANE_PATH_RADIANCE, c)[i] == sum);
        }
        for (uint32_t k = 0; k < 9; k++)
            assert_true(value(&both, PLANE_LENS_SLOPE, k, i) ==
                        value(&alone, PLANE_LENS_SLOPE, k, i));
        const float met = samples_f32(both.samples, PLANE_PATH_COVERAGE, 0)[i];
        expect_near((double)value(&both, PLANE_LENS_COVERAGE, 0, i), (double)met / 9, 1e-3);
        seen += met;
    }
    assert_true(seen > 256);
    assert_int_equal(count(&both, COUNTER_LENS_SAMPLES), count(&alone, COUNTER_LENS_SAMPLES));
    assert_int_equal(count(&both, COUNTER_RAYS_PRIMARY), count(&alone, COUNTER_RAYS_PRIMARY));
    traced_fini(&alone);
    traced_fini(&both);
    free(f);
}
