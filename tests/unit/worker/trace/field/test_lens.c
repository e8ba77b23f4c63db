/* The light field of the lens: what each of its samples sees, and how that moves. */
#include <stdlib.h>

#include "proto/lens_pattern.h"
#include "proto/pattern_path.h"
#include "tests/unit/worker/trace/field/lens_room.h"

#define HALF_MAX 65504.0f

static void expect_slope(float z, double expected)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(8, 3);
    add_lamp(f, 0, 0, z, 4 * z, (float[]){1, 1, 1});
    struct traced t = trace_all(f, &p);
    for (uint32_t k = 0; k < 9; k++)
        for (size_t i = 0; i < 64; i++)
            expect_near((double)value(&t, PLANE_LENS_SLOPE, k, i), expected,
                        1e-3 * fabs(expected) + 1e-4);
    for (size_t i = 0; i < 64; i++) assert_true(value(&t, PLANE_LENS_COVERAGE, 0, i) == 1.0f);
    traced_fini(&t);
    free(f);
}

/* f_px = 8, A = 0.2: 1.6 pixels a unit of 1/z. */
TEST(slopes_tell_the_side_of_the_focus)
{
    expect_slope(2, 1.6 * (0.5 - 0.25));
    expect_slope(4, 0);
    expect_slope(8, 1.6 * (0.125 - 0.25));
}

TEST(misses_are_infinitely_far)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(8, 2);
    add_lamp(f, -2, 0, 4, 2, (float[]){1, 2, 3}); /* the left half, in focus */
    struct traced t = trace_all(f, &p);
    for (size_t i = 0; i < 64; i++) {
        const bool left = i % 8 < 4;
        assert_true(value(&t, PLANE_LENS_COVERAGE, 0, i) == (left ? 1.0f : 0.0f));
        for (uint32_t k = 0; k < 4; k++) {
            expect_near((double)value(&t, PLANE_LENS_SLOPE, k, i), left ? 0.0 : -0.4, 1e-3);
            for (uint32_t c = 0; c < 3; c++)
                assert_true(value(&t, PLANE_LENS_RADIANCE, k * 3 + c, i) ==
                            (left ? (float)(c + 1) : 0.0f));
        }
    }
    traced_fini(&t);
    free(f);
}

enum { CELLS = 7 };

/* What a pinhole shows at x + s u is what a lens shows at (x, u): 7 x 7 squares out of focus tell
 * by their colour which of them each sample has met. */
static void expect_pattern(uint32_t blades, float z)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(16, 4);
    p.camera.blade_count = blades;
    p.camera.blade_rotation_rad = 0.4f;
    p.camera.aperture_radius = 1;
    const float side = z / CELLS;
    for (int k = 0; k < CELLS * CELLS; k++)
        add_lamp(f, side * (float)(k % CELLS - CELLS / 2), -side * (float)(k / CELLS - CELLS / 2),
                 z, 0.5f * side, (float[]){(float)(k % CELLS + 1), (float)(k / CELLS + 1), 0});
    struct traced t = trace_all(f, &p);
    const float slope = 16 * (1 / z - 0.25f), cell = 16.0f / CELLS;
    uint32_t sure = 0;
    for (uint32_t i = 0; i < 256 * 16; i++) {
        const int32_t x = (int32_t)(i / 16 % 16), y = (int32_t)(i / 16 / 16);
        const uint32_t sample = i % 16;
        float u[2], at[2];
        lens_pattern_point(&p, x, y, sample / 4, sample % 4, u);
        path_pair(path_key(p.pattern.seed, p.pattern.frame, x, y), sample, PATH_PIXEL, &at[0],
                  &at[1]);
        const float column = ((float)x + at[0] + slope * u[0]) / cell;
        const float row = ((float)y + at[1] + slope * u[1]) / cell;
        if (column < 0 || row < 0 || column > CELLS || row > CELLS) continue;
        if (fminf(fabsf(column - roundf(column)), fabsf(row - roundf(row))) < 1e-3f) continue;
        sure++;
        assert_true(value(&t, PLANE_LENS_RADIANCE, sample * 3, i / 16) == floorf(column) + 1);
        assert_true(value(&t, PLANE_LENS_RADIANCE, sample * 3 + 1, i / 16) == floorf(row) + 1);
    }
    assert_true(sure > 3000);
    traced_fini(&t);
    free(f);
}

TEST(samples_lie_where_the_pattern_says)
{
    expect_pattern(0, 3);
    expect_pattern(0, 6);
    expect_pattern(5, 3);
    expect_pattern(6, 6);
}

/* Mean and second moments of points over 64 x 64 pixels, l x l each. */
static void expect_moments(uint32_t blades, double second)
{
    struct plan p = lens_plan(64, 3);
    double sum[2] = {0}, squares[2] = {0}, product = 0, n = 0;
    p.camera.blade_count = blades;
    p.camera.blade_rotation_rad = 0.3f;
    for (int32_t i = 0; i < 64 * 64; i++)
        for (uint32_t k = 0; k < 9; k++, n++) {
            float u[2];
            lens_pattern_point(&p, i % 64, i / 64, k / 3, k % 3, u);
            for (int c = 0; c < 2; c++) {
                sum[c] += (double)u[c];
                squares[c] += (double)u[c] * (double)u[c];
            }
            product += (double)u[0] * (double)u[1];
        }
    for (int c = 0; c < 2; c++) {
        expect_near(sum[c] / n, 0, 2e-3);
        expect_near(squares[c] / n, second, 2e-3);
    }
    expect_near(product / n, 0, 2e-3);
}

/* A regular polygon's second moment over its area: (2 + cos(2 pi / n)) / 12. */
TEST(points_are_uniform_over_the_aperture)
{
    expect_moments(0, 0.25);
    expect_moments(3, (2 + cos(2 * M_PI / 3)) / 12);
    expect_moments(6, (2 + cos(2 * M_PI / 6)) / 12);
    expect_moments(7, (2 + cos(2 * M_PI / 7)) / 12);
}

TEST(tiles_do_not_matter)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(16, 5);
    add_room(f, &p);
    struct traced all = trace_all(f, &p);
    const struct rect part = {3, 5, 14, 12};
    struct traced some = trace(f, &p, part);
    for (uint32_t plane = PLANE_LENS_RADIANCE; plane <= PLANE_LENS_COVERAGE; plane++) {
        const uint32_t count = plane == PLANE_LENS_RADIANCE ? 75
                               : plane == PLANE_LENS_SLOPE  ? 25
                                                            : 1;
        for (uint32_t c = 0; c < count; c++)
            for (int32_t y = part.y0; y < part.y1; y++)
                for (int32_t x = part.x0; x < part.x1; x++)
                    assert_true(
                        value(&some, plane, c, (size_t)((y - part.y0) * 11 + x - part.x0)) ==
                        value(&all, plane, c, (size_t)(y * 16 + x)));
    }
    assert_int_equal(count(&some, COUNTER_LENS_SAMPLES), 11 * 7 * 25);
    assert_int_equal(count(&some, COUNTER_RAYS_PRIMARY), 11 * 7 * 25);
    assert_int_equal(count(&some, COUNTER_PATHS), 0);
    traced_fini(&all);
    traced_fini(&some);
    free(f);
}

/* Second sets are of the pixels that ask for them, whatever the tile, and show what the first do.
 */
TEST(second_sets_are_of_pixels_that_ask)
{
    enum { SIDE = 16, SEEDS = 24 };
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(SIDE, 3);
    add_room(f, &p);
    p.planes |= PLANE_BIT(LENS_SECOND_SET);
    p.lens_filter = LENS_FILTER_SHEARED;
    p.lens_extra = 9;
    struct traced t = trace_all(f, &p);
    const struct rect all = {0, 0, SIDE, SIDE}, part = {3, 5, 14, 12};
    uint8_t strata_map[SIDE * SIDE], cut[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; i++) strata_map[i] = i % 3 == 0 ? PLAN_LENS_EXTRA_STRATA : 0;
    for (int32_t y = part.y0, k = 0; y < part.y1; y++)
        for (int32_t x = part.x0; x < part.x1; x++) cut[k++] = strata_map[y * SIDE + x];
    double first = 0.0, second = 0.0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        struct samples *more, *some, *own;
        struct counters counters = {0};
        p.pattern.seed = seed;
        const struct plan_pass start = plan_scheduled_pass(&p, 0),
                               pass = {.number = 1,
                                       .strata = PLAN_LENS_EXTRA_STRATA,
                                       .strata_map = strata_map},
                               of_part = {.number = 1,
                                          .strata = PLAN_LENS_EXTRA_STRATA,
                                          .strata_map = cut};
#define TRACE(its_pass, its_rect, out, count)                                                      \
    assert_int_equal(tile_trace_pass(t.tracer,                                                     \
                                     &(struct tile_job){.scene = t.scene,                          \
                                                        .plan = &p,                                \
                                                        .pass = its_pass,                          \
                                                        .rect = its_rect,                          \
                                                        .counters = count},                        \
                                     out),                                                         \
                     0)
        TRACE(&start, all, &own, &(struct counters){{0}});
        TRACE(&pass, all, &more, &counters);
        TRACE(&of_part, part, &some, &(struct counters){{0}});
#undef TRACE
        assert_int_equal(counters.value[COUNTER_PATHS], 86 * 36);
        assert_int_equal(counters.value[COUNTER_SKIPPED_ENOUGH], 256 - 86);
        for (int i = 0; i < SIDE * SIDE; i++) {
            double root = (double)samples_f32(more, PLANE_LENS_SECOND_SET, 3)[i], square = 0.0;
            for (uint32_t c = 0; c < 3; c++) {
                const double mean = (double)samples_f32(more, PLANE_LENS_SECOND_SET, c)[i];
                square += mean * mean;
                second += mean;
                for (uint32_t k = 0; k < 9 && strata_map[i]; k++)
                    first += (double)samples_f32(own, PLANE_LENS_RADIANCE, k * 3 + c)[i] / 9;
            }
            assert_true(strata_map[i] ? root * root > 0.999 * square : root == 0.0);
        }
        for (int32_t y = part.y0; y < part.y1; y++)
            for (int32_t x = part.x0; x < part.x1; x++)
                for (uint32_t c = 0; c < 4; c++)
                    assert_true(samples_f32(some, PLANE_LENS_SECOND_SET,
                                            c)[(y - part.y0) * 11 + x - part.x0] ==
                                samples_f32(more, PLANE_LENS_SECOND_SET, c)[y * SIDE + x]);
        samples_destroy(&own);
        samples_destroy(&more);
        samples_destroy(&some);
    }
    assert_true(first > 100 && fabs(second / first - 1.0) < 0.03);
    traced_fini(&t);
    free(f);
}

/* Every number of the samples is one that the other side takes. */
static void expect_finite(float radius, float focus)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(8, 3);
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    p.camera.aperture_radius = radius;
    p.camera.focus_distance = focus;
    add_room(f, &p);
    struct traced t = trace_all(f, &p);
    bytes_writer_init(&w);
    assert_int_equal(samples_pack(t.samples, PACKING_SMALL, &w, NULL), 0);
    const int error = samples_unpack(w.data, w.size_bytes, &p, 0, 8, 8, &back, &fault);
    if (error) fail_msg("radius %g, focus %g: %s: %s", radius, focus, fault.pointer, fault.detail);
    samples_destroy(&back);
    bytes_writer_fini(&w);
    traced_fini(&t);
    free(f);
}

TEST(odd_lenses_give_numbers)
{
    static const float radii[] = {1e-30f, 1e-6f, 100, 1e9f, 1e15f};
    static const float focuses[] = {1e-38f, 1e-20f, 1e-6f, 100, 1e15f};
    for (size_t i = 0; i < 5; i++)
        for (size_t k = 0; k < 5; k++) expect_finite(radii[i], focuses[k]);
}

/* What is nearly at the lens moves as far as numbers go. */
TEST(slopes_are_bounded)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(8, 1);
    add_lamp(f, 0, 0, 1e-6f, 1, (float[]){1, 1, 1});
    struct traced t = trace_all(f, &p);
    for (size_t i = 0; i < 64; i++) assert_true(value(&t, PLANE_LENS_SLOPE, 0, i) == HALF_MAX);
    traced_fini(&t);
    free(f);
}

TEST(many_samples_can_be_stopped)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lens_plan(8, 16);
    struct traced t = {0};
    _Atomic uint64_t progress = 0;
    const _Atomic bool stop = true;
    add_room(f, &p);
    open_traced(f, &t);
    assert_int_equal(trace_tile(&t,
                                (struct tile_job){.plan = &p,
                                                  .rect = (struct rect){0, 0, 8, 8},
                                                  .progress = &progress,
                                                  .stop = &stop},
                                0, &t.samples),
                     ERR_STATE);
    assert_int_equal(count(&t, COUNTER_LENS_SAMPLES), 16 * 16); /* a batch of the first block */
    traced_fini(&t);
    free(f);
}
