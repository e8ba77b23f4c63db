/* The light field of the lens: what each of its samples sees, and how that moves. */
#include <stdlib.h>

#include "proto/half.h"
#include "proto/lens_pattern.h"
#include "proto/pattern_path.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#define HALF_MAX 65504.0f

/* A plan of lens samples alone, from the origin along -z, focused on z = 4. */
static struct plan lens_plan(int32_t side_px, uint32_t l)
{
    struct plan p = fixture_plan(side_px, side_px, (float[]){0, 0, 0}, 0.5f);
    p.planes = PLANES_LENS;
    p.light_planes = 0;
    p.lens_strata_per_axis = l;
    p.camera.aperture_radius = 0.2f;
    p.camera.focus_distance = 4;
    return p;
}

/* A square that glows and reflects nothing, facing the camera at distance z. */
static void add_lamp(struct scene_fixture *f, float x, float y, float z, float half,
                     const float color[3])
{
    const uint32_t black = fixture_material(f, 0, 0, 0);
    memcpy(f->materials[black].emission, color, sizeof f->materials[black].emission);
    fixture_panel(f, black, (float[]){x, y, -z}, (float[]){half, 0, 0}, (float[]){0, half, 0});
}

static float value(const struct traced *t, enum plane_id plane, uint32_t component, size_t i)
{
    if (plane == PLANE_LENS_RADIANCE) return samples_f32(t->samples, plane, component)[i];
    return half_to_float(samples_u16(t->samples, plane, component)[i]);
}

static void expect_near(double is, double should, double tolerance)
{
    if (!(fabs(is - should) <= tolerance)) fail_msg("%g is not %g", is, should);
}

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

/* A room's corner with a lamp, out of focus at both ends. */
static void add_room(struct scene_fixture *f, struct plan *p)
{
    const uint32_t grey = fixture_material(f, 0.7f, 0.6f, 0.5f);
    fixture_panel(f, grey, (float[]){0, -0.5f, -6}, (float[]){6, 0, 0}, (float[]){0, 0, -6});
    fixture_panel(f, grey, (float[]){0, 0, -9}, (float[]){6, 0, 0}, (float[]){0, 6, 0});
    fixture_panel(f, grey, (float[]){0.3f, 0, -2.5f}, (float[]){0.3f, 0, 0}, (float[]){0, 0.3f, 0});
    add_lamp(f, -0.5f, 0.5f, 3, 0.25f, (float[]){4, 5, 6});
    fixture_ceiling_light(p, 0, 3, -4, 0.5f, 1);
    p->bounces = 2;
}

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
