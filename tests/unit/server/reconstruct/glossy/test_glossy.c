/* Filters of glossy lobes: what they keep, what they must not mix, and how they converge. */
#include "tests/unit/server/reconstruct/glossy/glossy_scene.h"
#include "tests/unit/unit.h"

/* Of a picture of LINES squared, the part that is looked at. */
enum { LINES = 512, SIDE = 48, AREA = SIDE * SIDE, FIRST = 232 };

static const struct rect all = {FIRST, FIRST, FIRST + SIDE, FIRST + SIDE};

/* Light of the floor without noise; the last one is kept, since many filters are held to it. */
static const float *truth_of(float alpha, float other)
{
    static float truth[AREA], last[2];
    if (last[0] == alpha && last[1] == other) return truth;
    struct plan plan;
    floor_plan(&plan, LINES, GLOSSY_FILTER_NONE, 2);
    struct patch *patch = floor_patch(&plan, all, alpha, other, TRUTH);
    memcpy(truth, patch->glossy[0], sizeof truth);
    patch_destroy(&patch);
    last[0] = alpha;
    last[1] = other;
    return truth;
}

static float error_of(uint32_t filter, uint32_t l, float alpha, float other)
{
    struct plan plan;
    floor_plan(&plan, LINES, filter, l);
    struct patch *patch = floor_patch(&plan, all, alpha, other, l * l);
    struct floor_picture p = floor_filter(&plan, patch, all);
    const double error = floor_rms(p.channel[0], truth_of(alpha, other), AREA);
    floor_picture_fini(&p);
    patch_destroy(&patch);
    return (float)error;
}

TEST(errors_fall_with_samples)
{
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        float before = 1e9f;
        for (uint32_t l = 2; l <= 16; l *= 2) {
            const float plain = error_of(GLOSSY_FILTER_NONE, l, 0.16f, 0.16f);
            const float own = error_of(f, l, 0.16f, 0.16f);
            if (!(own < plain && own < before))
                fail_msg("filter %u, %u samples: %g after %g, the average %g", f, l * l,
                         (double)own, (double)before, (double)plain);
            before = own;
        }
    }
    assert_true(error_of(GLOSSY_FILTER_VIRTUAL_HIT, 2, 0.16f, 0.16f) <
                0.4f * error_of(GLOSSY_FILTER_NONE, 2, 0.16f, 0.16f));
}

/* Pixels with more rays are filtered as all would be that have so many. */
TEST(widths_follow_each_pixels_rays)
{
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        struct plan few, many;
        floor_plan(&few, LINES, f, 4);
        floor_plan(&many, LINES, f, 8);
        struct patch *patch = floor_patch(&few, all, 0.16f, 0.3f, 16);
        float rays[AREA];
        struct floor_picture at_few = floor_filter(&few, patch, all);
        struct floor_picture at_many = floor_filter(&many, patch, all);
        patch->glossy_rays = rays;
        for (int i = 0; i < AREA; i++) rays[i] = 16.0f;
        struct floor_picture same = floor_filter(&few, patch, all);
        for (int i = 0; i < AREA; i++) rays[i] = 64.0f;
        struct floor_picture more = floor_filter(&few, patch, all);
        const size_t bytes = AREA * sizeof(float);
        assert_memory_equal(same.channel[0], at_few.channel[0], bytes);
        assert_true(floor_rms(at_many.channel[0], at_few.channel[0], AREA) > 1e-3);
        /* halos reach as far as the fewest rays ask for, where weights are small */
        assert_true(floor_rms(more.channel[0], at_many.channel[0], AREA) < 2e-4);
        /* rows are filtered by themselves at first: where a column has its own, so has its mean */
        for (int i = 0; i < AREA; i++) rays[i] = i % SIDE < SIDE / 2 ? 16.0f : 64.0f;
        struct floor_picture mixed = floor_filter(&few, patch, all);
        for (int i = 0; i < AREA; i++)
            assert_true(mixed.channel[0][i] ==
                        (i % SIDE < SIDE / 2 ? same.channel[0][i] : more.channel[0][i]));
        struct floor_picture *const made[] = {&at_few, &at_many, &same, &more, &mixed};
        for (int k = 0; k < 5; k++) floor_picture_fini(made[k]);
        patch_destroy(&patch);
    }
}

/* Sharp tiles between rough ones stay as sharp as they are. */
TEST(roughness_has_edges)
{
    const float plain = error_of(GLOSSY_FILTER_NONE, 4, 0.012f, 0.3f);
    assert_true(error_of(GLOSSY_FILTER_VIRTUAL_HIT, 4, 0.012f, 0.3f) < 0.6f * plain);
    assert_true(error_of(GLOSSY_FILTER_VIRTUAL_HIT, 4, 0.012f, 0.3f) <
                0.7f * error_of(GLOSSY_FILTER_BANDLIMIT, 4, 0.012f, 0.3f));
    for (uint32_t f = GLOSSY_FILTER_SG; f <= GLOSSY_FILTER_ASG; f++)
        assert_true(error_of(f, 4, 0.012f, 0.3f) < 0.6f * plain);
}

/* Weights that vary go out of what lobes see of one light; without them nothing would be exact. */
TEST(even_light_stays_even)
{
    struct plan plan;
    uint32_t random = 3;
    floor_plan(&plan, LINES, GLOSSY_FILTER_VIRTUAL_HIT, 2);
    struct patch *patch = floor_patch(&plan, all, 0.1f, 0.2f, 1);
    for (size_t i = 0; i < AREA; i++) {
        patch->glossy_weight[i] = 0.5f + floor_random(&random);
        for (int c = 0; c < 3; c++)
            patch->glossy[c][i] = 0.25f * (float)(c + 1) * patch->glossy_weight[i];
    }
    struct floor_picture p = floor_filter(&plan, patch, all);
    for (size_t i = 0; i < AREA; i++)
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(p.channel[c][i] - 0.25f * (float)(c + 1)) < 1e-5f);
    floor_picture_fini(&p);
    patch_destroy(&patch);
}

TEST(objects_do_not_mix)
{
    struct plan plan;
    floor_plan(&plan, LINES, GLOSSY_FILTER_VIRTUAL_HIT, 2);
    struct patch *patch = floor_patch(&plan, all, 0.3f, 0.3f, 4);
    for (size_t i = 0; i < AREA; i++) {
        const bool left = i % SIDE < SIDE / 2;
        patch->id[i] = left ? 1 : 2;
        for (int c = 0; c < 3; c++) patch->glossy[c][i] = left ? 1.0f : 2.0f;
    }
    struct floor_picture p = floor_filter(&plan, patch, all);
    for (size_t i = 0; i < AREA; i++)
        assert_true(p.channel[0][i] == (i % SIDE < SIDE / 2 ? 1.0f : 2.0f));
    floor_picture_fini(&p);
    patch_destroy(&patch);
}

TEST(blocks_are_the_whole)
{
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        struct plan plan;
        floor_plan(&plan, LINES, f, 3);
        const struct rect inner = {FIRST + 20, FIRST + 8, FIRST + 31, FIRST + 25};
        const struct rect seen = rect_intersect(rect_grow(inner, glossy_halo_px(&plan)), all);
        struct patch *whole = floor_patch(&plan, all, 0.05f, 0.2f, 9);
        struct patch *part = floor_patch(&plan, seen, 0.05f, 0.2f, 9);
        struct floor_picture a = floor_filter(&plan, whole, all);
        struct floor_picture b = floor_filter(&plan, part, inner);
        for (int32_t y = inner.y0; y < inner.y1; y++)
            for (int32_t x = inner.x0; x < inner.x1; x++)
                assert_true(a.channel[1][patch_pixel(whole, x, y)] ==
                            b.channel[1][patch_pixel(part, x, y)]);
        assert_int_equal(a.statistics.pixels_filtered, AREA);
        assert_int_equal(b.statistics.pixels_filtered, rect_area(inner));
        floor_picture_fini(&a);
        floor_picture_fini(&b);
        patch_destroy(&whole);
        patch_destroy(&part);
    }
}

struct known {
    double error, estimate, within; /* RMS, RMS, share of pixels within two estimates */
};

enum { FRAMES = 8 };

/* Adds how well a filter knows its own error in one frame. */
static void add_known(const struct plan *plan, const float *truth, float alpha, struct known *k)
{
    static float square[3][AREA], out[3][AREA];
    const uint32_t l = plan->indirect_strata_per_axis;
    struct glossy_statistics statistics = {0};
    float *const outs[3] = {out[0], out[1], out[2]};
    float *const squares[3] = {square[0], square[1], square[2]};
    struct patch *patch = floor_patch(plan, all, alpha, alpha, 1);
    floor_halves(plan, patch, alpha, l * l);
    assert_int_equal(glossy_filter_with_error(plan, patch, all, outs, squares, &statistics), 0);
    for (size_t i = 0; i < AREA; i++) {
        const double off = (double)out[0][i] - (double)truth[i], estimate = (double)square[0][i];
        k->error += off * off / (AREA * FRAMES);
        k->estimate += estimate / (AREA * FRAMES);
        k->within += off * off <= 4 * estimate ? 1.0 / (AREA * FRAMES) : 0.0;
    }
    patch_destroy(&patch);
}

TEST(filters_know_their_errors)
{
    const float alpha = 0.16f;
    struct plan plan;
    floor_plan(&plan, LINES, GLOSSY_FILTER_NONE, 2);
    struct patch *truth = floor_patch(&plan, all, alpha, alpha, TRUTH);
    for (uint32_t f = GLOSSY_FILTER_NONE; f <= GLOSSY_FILTER_LAST; f++)
        for (uint32_t l = 2; l <= 8; l += 2) {
            struct known k = {0};
            floor_plan(&plan, LINES, f, l);
            plan.planes |= PLANE_BIT(GLOSSY_HALF);
            for (plan.pattern.frame = 0; plan.pattern.frame < FRAMES; plan.pattern.frame++)
                add_known(&plan, truth->glossy[0], alpha, &k);
            const double over = sqrt(k.estimate / k.error);
            if (!(k.within >= 0.88 && over > 0.8 && over < 1.4))
                fail_msg("filter %u, %u rays: %g, estimated %g times as much, within two of these "
                         "%g",
                         f, l * l, sqrt(k.error), over, k.within);
        }
    patch_destroy(&truth);
}

/* Errors are asked for where there are halves; they change nothing else. */
TEST(errors_change_nothing)
{
    for (uint32_t f = GLOSSY_FILTER_NONE; f <= GLOSSY_FILTER_LAST; f++) {
        static float square[3][AREA];
        float *const squares[3] = {square[0], square[1], square[2]};
        struct glossy_statistics statistics = {0};
        struct plan plan, without;
        floor_plan(&without, LINES, f, 2);
        floor_plan(&plan, LINES, f, 2);
        plan.planes |= PLANE_BIT(GLOSSY_HALF);
        struct patch *patch = floor_patch(&plan, all, 0.05f, 0.2f, 4);
        floor_halves(&plan, patch, 0.2f, 4);
        struct floor_picture a = floor_filter(&without, patch, all);
        struct floor_picture b = floor_filter(&without, patch, all);
        assert_int_equal(
            glossy_filter_with_error(&without, patch, all, b.channel, squares, &statistics),
            ERR_RANGE);
        assert_int_equal(
            glossy_filter_with_error(&plan, patch, all, b.channel, squares, &statistics), 0);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(a.channel[c], b.channel[c], AREA * sizeof(float));
        assert_int_equal(statistics.pixels_filtered, a.statistics.pixels_filtered);
        floor_picture_fini(&a);
        floor_picture_fini(&b);
        patch_destroy(&patch);
    }
}

/* Blocks know the same errors as the whole, also where tiles have more rays than others. */
TEST(errors_of_blocks_are_those_of_the_whole)
{
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        static float square[2][3][AREA], out[2][3][AREA];
        struct glossy_statistics statistics = {0};
        struct plan plan;
        floor_plan(&plan, LINES, f, 8);
        plan.planes = (plan.planes | PLANE_BIT(GLOSSY_HALF) | PLANE_BIT(INDIRECT_HALVES) |
                       PLANE_BIT(BOUNCE_DISTANCE_MIN)) &
                      ~PLANE_BIT(INDIRECT_MEAN);
        plan.target_error = 0.1f;
        plan.spp_max = 4096;
        const struct rect inner = {FIRST + 20, FIRST + 18, FIRST + 31, FIRST + 29};
        const struct rect seen = rect_intersect(rect_grow(inner, glossy_halo_px(&plan)), all);
        const struct rect rects[2] = {all, seen}, inners[2] = {all, inner};
        struct patch *patches[2];
        for (int k = 0; k < 2; k++) {
            float *const outs[3] = {out[k][0], out[k][1], out[k][2]};
            float *const squares[3] = {square[k][0], square[k][1], square[k][2]};
            struct patch *p = patches[k] = floor_patch(&plan, rects[k], 0.2f, 0.2f, 1);
            floor_halves(&plan, p, 0.2f, 64);
            for (int32_t y = p->rect.y0; y < p->rect.y1; y++)
                for (int32_t x = p->rect.x0; x < p->rect.x1; x++)
                    p->glossy_rays[patch_pixel(p, x, y)] = x < FIRST + 25 ? 64.0f : 1024.0f;
            assert_int_equal(
                glossy_filter_with_error(&plan, p, inners[k], outs, squares, &statistics), 0);
        }
        for (int32_t y = inner.y0; y < inner.y1; y++)
            for (int32_t x = inner.x0; x < inner.x1; x++) {
                const size_t a = patch_pixel(patches[0], x, y), b = patch_pixel(patches[1], x, y);
                assert_true(out[0][1][a] == out[1][1][b]);
                assert_true(square[0][1][a] == square[1][1][b]);
            }
        for (int k = 0; k < 2; k++) patch_destroy(&patches[k]);
    }
}

/* More rays make a pixel's filter narrower, and no other's. */
TEST(rays_make_filters_narrower)
{
    struct plan plan;
    floor_plan(&plan, LINES, GLOSSY_FILTER_VIRTUAL_HIT, 2);
    plan.planes = (plan.planes | PLANE_BIT(GLOSSY_HALF) | PLANE_BIT(INDIRECT_HALVES) |
                   PLANE_BIT(BOUNCE_DISTANCE_MIN)) &
                  ~PLANE_BIT(INDIRECT_MEAN);
    plan.target_error = 0.1f;
    plan.spp_max = 65536;
    struct patch *patch = floor_patch(&plan, all, 0.2f, 0.2f, 4);
    for (size_t i = 0; i < AREA; i++) patch->glossy_rays[i] = 4.0f;
    struct floor_picture few = floor_filter(&plan, patch, all);
    for (size_t i = 0; i < AREA; i++) patch->glossy_rays[i] = i % SIDE < SIDE / 2 ? 4.0f : 65536.0f;
    struct floor_picture many = floor_filter(&plan, patch, all);
    size_t same = 0;
    double off_few = 0, off_many = 0;
    for (size_t i = 0; i < AREA; i++) {
        same += many.channel[0][i] == few.channel[0][i];
        if (i % SIDE < SIDE / 2) continue;
        off_few += fabs((double)few.channel[0][i] - (double)patch->glossy[0][i]);
        off_many += fabs((double)many.channel[0][i] - (double)patch->glossy[0][i]);
    }
    assert_true(off_many < 0.3 * off_few);
    assert_true(same >
                AREA / 4); /* but near those: columns are filtered as they are, rows reach over */
    floor_picture_fini(&few);
    floor_picture_fini(&many);
    patch_destroy(&patch);
}

TEST(where_nothing_shines_nothing_runs)
{
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        struct plan plan;
        floor_plan(&plan, LINES, f, 3);
        struct patch *patch = floor_patch(&plan, all, 0.0f, 0.0f, 1);
        struct floor_picture p = floor_filter(&plan, patch, all);
        for (size_t i = 0; i < AREA; i++) assert_true(p.channel[2][i] == 0.0f);
        assert_int_equal(p.statistics.pixels_filtered, 0);
        assert_int_equal(p.statistics.pixels_skipped, AREA);
        assert_int_equal(p.statistics.blocks_skipped, 1);
        floor_picture_fini(&p);
        patch_destroy(&patch);
    }
}

/* Numbers at the ends of their ranges: nothing met, everything touched, the least alpha a plane
 * has, surfaces seen along themselves, no weight. */
TEST(odd_numbers_stay_finite)
{
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        struct plan plan;
        floor_plan(&plan, LINES, f, 2);
        struct patch *patch = floor_patch(&plan, all, 0.2f, 1.0f, 4);
        for (size_t i = 0; i < AREA; i++) {
            if (i % 7 == 0) patch->glossy_nearness[i] = 0.0f;
            if (i % 11 == 0) patch->glossy_nearness[i] = 1e16f;
            if (i % 13 == 0) patch->glossy_alpha[i] = 1.0f / 65535.0f;
            if (i % 17 == 0) patch->normal[1][i] = 0.0f, patch->normal[0][i] = 1.0f;
            if (i % 19 == 0) patch->glossy_weight[i] = 0.0f;
            if (i % 23 == 0) patch->glossy[1][i] = 65504.0f;
            if (i % 29 == 0) patch->depth[i] = i % 2 ? 0.0f : 1e16f;
        }
        struct floor_picture p = floor_filter(&plan, patch, all);
        for (size_t i = 0; i < AREA; i++)
            for (int c = 0; c < 3; c++)
                assert_true(p.channel[c][i] >= 0.0f && p.channel[c][i] < INFINITY);
        floor_picture_fini(&p);
        patch_destroy(&patch);
    }
}

TEST(one_pixel_is_itself)
{
    const struct rect one = {0, 0, 1, 1};
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        struct plan plan;
        floor_plan(&plan, 1, f, 2);
        struct patch *patch = floor_patch(&plan, one, 0.2f, 0.2f, 4);
        struct floor_picture p = floor_filter(&plan, patch, one);
        assert_true(p.channel[0][0] == patch->glossy[0][0]);
        floor_picture_fini(&p);
        patch_destroy(&patch);
    }
}

/* Widths shrink with samples and grow with lines and mu, to the reach and no farther. */
TEST(halos_follow_the_plan)
{
    struct plan plan;
    floor_plan(&plan, 512, GLOSSY_FILTER_VIRTUAL_HIT, 4);
    assert_int_equal(glossy_halo_px(&plan), 12);
    plan.indirect_strata_per_axis = 16;
    assert_true(glossy_halo_px(&plan) < 12);
    plan.indirect_strata_per_axis = 2;
    assert_true(glossy_halo_px(&plan) > 12);
    plan.height_px = 16384;
    plan.mu = LIMIT_FILTER_MU;
    assert_int_equal(glossy_halo_px(&plan), 64);
    plan.glossy_filter = GLOSSY_FILTER_NONE;
    assert_int_equal(glossy_halo_px(&plan), 0);
}

TEST(what_is_missing_is_refused)
{
    struct plan plan;
    struct glossy_statistics statistics = {0};
    static float room[3][AREA];
    float *const out[3] = {room[0], room[1], room[2]};
    floor_plan(&plan, LINES, GLOSSY_FILTER_VIRTUAL_HIT, 2);
    struct patch *patch = floor_patch(&plan, all, 0.2f, 0.2f, 4);
    const struct rect outside = {FIRST, FIRST, FIRST + SIDE + 1, FIRST + 1},
                      empty = {FIRST, FIRST, FIRST, FIRST + 9};
    assert_int_equal(glossy_filter(&plan, patch, outside, out, &statistics), ERR_RANGE);
    assert_int_equal(glossy_filter(&plan, patch, empty, out, &statistics), ERR_RANGE);
    plan.glossy_filter = GLOSSY_FILTER_LAST + 1;
    assert_int_equal(glossy_filter(&plan, patch, all, out, &statistics), ERR_RANGE);
    plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT;
    patch->glossy_nearness = NULL;
    assert_int_equal(glossy_filter(&plan, patch, all, out, &statistics), ERR_RANGE);
    assert_int_equal(statistics.pixels_filtered + statistics.pixels_skipped, 0);
    patch_destroy(&patch);
}
