/* Second sets of paths through the lens: who needs them, and what they do to the picture. */
#include <stdlib.h>

#include "server/reconstruct/lens/lens_second_set.h"
#include "tests/unit/server/reconstruct/lens/lens_scene.h"
#include "tests/unit/unit.h"

#define AREA  ((size_t)LENS_SIDE * LENS_SIDE)
#define PATHS (PLAN_LENS_EXTRA_STRATA * PLAN_LENS_EXTRA_STRATA)

static const struct rect all = {0, 0, LENS_SIDE, LENS_SIDE};

struct extra_picture {
    struct lens_picture first;
    float *more, *paths;
};

/* A first set of 9, and a second one's means for the pixels that `levels` of at least `least` ask
 * for. */
static void create(enum lens_scene scene, struct extra_picture *out)
{
    lens_picture_create(scene, 3, 0, &out->first);
    out->first.plan.lens_extra = 9;
    out->more = calloc(4 * AREA, sizeof *out->more);
    out->paths = calloc(AREA, sizeof *out->paths);
    out->first.patch.lens_second_set = out->more;
    out->first.patch.lens_paths = out->paths;
}

static void destroy(struct extra_picture *p)
{
    lens_picture_destroy(&p->first);
    free(p->more);
    free(p->paths);
}

static void trace_second(enum lens_scene scene, const uint8_t *levels, uint8_t least,
                         struct extra_picture *p)
{
    struct lens_picture second;
    lens_picture_create_seeded(scene, PLAN_LENS_EXTRA_STRATA, 0, 77, &second);
    for (size_t i = 0; i < AREA; i++) {
        if (levels[i] < least) continue;
        double square = 0.0;
        p->paths[i] = PATHS;
        for (size_t c = 0; c < 3; c++) {
            double sum = 0.0;
            for (size_t j = 0; j < PATHS; j++) {
                const double value = (double)second.patch.lens_radiance[(j * 3 + c) * AREA + i];
                sum += value / PATHS;
                square += value * value / PATHS;
            }
            p->more[c * AREA + i] = (float)sum;
        }
        p->more[3 * AREA + i] = (float)sqrt(square);
    }
    lens_picture_destroy(&second);
}

/* The level that a quarter of the pixels reaches. */
static uint8_t level_of_quarter(const uint8_t *levels)
{
    size_t count[256] = {0}, sum = 0;
    for (size_t i = 0; i < AREA; i++) count[levels[i]]++;
    uint8_t level = 255;
    while (level > 1 && sum + count[level] < AREA / 4) sum += count[level--];
    return level;
}

TEST(errors_fall)
{
    static const double gain[LENS_SCENES] = {1.15, 1.04, 0.0, 1.3};
    for (int scene = 0; scene < LENS_SCENES; scene++) {
        if (scene == LENS_LAMPS) continue; /* few of any paths meet one */
        struct extra_picture p;
        struct lens_statistics statistics;
        static uint8_t levels[AREA];
        float *reference = lens_reference((enum lens_scene)scene, 0);
        create((enum lens_scene)scene, &p);
        p.first.patch.lens_paths = NULL;
        assert_int_equal(lens_second_set_levels(&p.first.plan, &p.first.patch, all, levels), 0);
        p.first.patch.lens_paths = p.paths;
        trace_second((enum lens_scene)scene, levels, level_of_quarter(levels), &p);
        assert_int_equal(lens_run(&p.first, LENS_FILTER_SHEARED, &statistics), 0);
        const struct lens_error before = lens_error_of(&p.first, reference);
        assert_int_equal(lens_second_set_mix(&p.first.plan, &p.first.patch, all, p.first.out), 0);
        const struct lens_error after = lens_error_of(&p.first, reference);
        print_message("%-6s: %.2f %% of the mean, %.2f %% with second sets\n",
                      lens_scene_names[scene], 100 * before.all, 100 * after.all);
        assert_true(after.all * gain[scene] < before.all);
        free(reference);
        destroy(&p);
    }
}

/* Square (32, 32) .. (40, 40) is noisy and has slope `slope`; all else is even. */
static uint8_t level_in_square(struct extra_picture *p, float slope, float noise)
{
    static uint8_t levels[AREA];
    for (size_t i = 0; i < AREA; i++) {
        const size_t x = i % LENS_SIDE, y = i / LENS_SIDE;
        const bool in = x >= 32 && x < 40 && y >= 32 && y < 40;
        for (size_t j = 0; j < 9; j++) {
            p->first.patch.lens_slope[j * AREA + i] = slope;
            for (size_t c = 0; c < 3; c++)
                p->first.patch.lens_radiance[(j * 3 + c) * AREA + i] =
                    1.0f + (in && j % 2 ? noise : 0.0f);
        }
    }
    assert_int_equal(lens_second_set_levels(&p->first.plan, &p->first.patch, all, levels), 0);
    assert_int_equal(levels[20 * LENS_SIDE + 20], 0);
    assert_int_equal(levels[30 * LENS_SIDE + 36], 0);
    assert_true(levels[31 * LENS_SIDE + 36] > 0); /* beside it */
    return levels[36 * LENS_SIDE + 36];
}

TEST(levels_tell_of_noise_in_focus)
{
    struct extra_picture p;
    create(LENS_FENCE, &p);
    p.first.patch.lens_paths = NULL;
    const uint8_t level = level_in_square(&p, 0.0f, 1.0f);
    assert_int_equal(level_in_square(&p, 0.0f, 2.0f), level + 4); /* of squares, two an octave */
    assert_true(level_in_square(&p, 4.0f, 1.0f) <= level - 2 * 5);
    assert_true(level_in_square(&p, -4.0f, 1.0f) <= level - 2 * 5);
    level_in_square(&p, 0.0f, 1e25f); /* whose square is infinite */
    destroy(&p);
}

/* Of a second set without noise all counts, of one all noise next to nothing; else nothing moves.
 */
TEST(errors_weigh)
{
    struct extra_picture p;
    struct lens_statistics statistics;
    create(LENS_FLOOR, &p);
    assert_int_equal(lens_run(&p.first, LENS_FILTER_SHEARED, &statistics), 0);
    float *before = malloc(3 * AREA * sizeof *before);
    memcpy(before, p.first.out[0], 3 * AREA * sizeof *before);
    assert_int_equal(lens_second_set_mix(&p.first.plan, &p.first.patch, all, p.first.out), 0);
    assert_memory_equal(before, p.first.out[0], 3 * AREA * sizeof *before);
    const size_t sure = 20 * LENS_SIDE + 20, noisy = 60 * LENS_SIDE + 60;
    p.paths[sure] = p.paths[noisy] = PATHS;
    for (size_t c = 0; c < 3; c++) p.more[c * AREA + sure] = p.more[c * AREA + noisy] = 2.0f;
    p.more[3 * AREA + sure] = sqrtf(12.0f) * 0.999999f;
    p.more[3 * AREA + noisy] = 1e6f;
    assert_int_equal(lens_second_set_mix(&p.first.plan, &p.first.patch, all, p.first.out), 0);
    for (size_t i = 0; i < AREA; i++)
        for (size_t c = 0; c < 3; c++) {
            const float is = p.first.out[c][i], was = before[c * AREA + i];
            if (i == sure)
                assert_true(fabsf(is - 2.0f) < 1e-5f);
            else if (i == noisy)
                assert_true(fabsf(is - was) < 1e-5f);
            else
                assert_true(is == was);
        }
    free(before);
    destroy(&p);
}
