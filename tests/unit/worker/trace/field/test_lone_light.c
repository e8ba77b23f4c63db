/* The light of lone sub-samples. */
#include <stdlib.h>

#include "proto/half.h"
#include "tests/unit/worker/trace/field/lone_strips.h"
#include "worker/shade/lanes.h"

/* The point of a strip that a sub-sample sees: y is 2, and so is the way down to it. */
static void strip_point(const struct plan *p, uint32_t place, double out[3])
{
    float at[2];
    const int32_t pixel = (int32_t)(place / 3), x = pixel % SIDE, y = pixel / SIDE;
    pattern_pixel(&p->pattern, x, y, place % 3, 3, at);
    out[0] = (2.0 * (x + (double)at[0]) / SIDE - 1.0) * 0.5 * 2.0;
    out[1] = 2.0;
    out[2] = -(1.0 - 2.0 * (y + (double)at[1]) / SIDE) * 0.5 * 2.0;
}

TEST(a_bulb_lights_each_at_its_place)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = strips_plan(f, 0.5f);
    struct traced t = trace_all(f, &p);
    const struct sparse_list *list = t.samples->lone;
    assert_non_null(list);
    for (uint32_t e = 0; e < list->count; e++) {
        double point[3], squared = 0;
        const float *bulb = p.lights[0].position;
        strip_point(&p, list->words[e], point);
        for (int c = 0; c < 3; c++)
            squared += ((double)bulb[c] - point[c]) * ((double)bulb[c] - point[c]);
        const double e_at = ((double)bulb[1] - 2.0) / sqrt(squared) / squared;
        for (uint32_t c = 0; c < 3; c++) {
            const double expected = e_at * (double)p.lights[0].color[c] / 3.14159265358979;
            const double got = (double)lone_values(list, LONE_DIRECT, c)[e];
            if (fabs(got - expected) > 1e-4 * expected)
                fail_msg("place %u has %g of %g", list->words[e], got, expected);
        }
    }
    traced_fini(&t);
    free(f);
}

/* In the shadow of a lid none is lit. */
TEST(shadows_fall_on_them)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    fixture_panel(f, 0, (float[]){0, 4.5f, 0}, (float[]){2, 0, 0}, (float[]){0, 0, -2});
    struct traced t = trace_all(f, &p);
    const struct sparse_list *list = t.samples->lone;
    assert_non_null(list);
    for (uint32_t e = 0; e < list->count; e++)
        for (uint32_t c = 0; c < 3; c++) assert_true(lone_values(list, LONE_DIRECT, c)[e] == 0.0f);
    traced_fini(&t);
    free(f);
}

/* A sub-sample's numbers are its own: others than its pixel's, and other sub-samples'. */
/* How much of their light goes with that of the pixel's centre, one sample each: all of it, almost,
 * if both drew the same numbers. */
static double correlation_with_pixels(const struct samples *samples, uint32_t subs)
{
    const struct sparse_list *list = samples->lone;
    const float *own = lone_values(list, LONE_DIRECT, 0);
    const float *pixels = samples_light_irradiance(samples, 0);
    double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    for (uint32_t e = 0; e < list->count; e++) {
        const double a = (double)own[e], b = (double)pixels[list->words[e] / subs];
        if (!(a > 0 && b > 0)) continue;
        n++, x += a, y += b, xx += a * a, yy += b * b, xy += a * b;
    }
    assert_true(n > 20);
    return (n * xy - x * y) / sqrt((n * xx - x * x) * (n * yy - y * y));
}

TEST(noise_is_their_own)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    p.light_count = 0;
    p.light_planes = 0;
    fixture_ceiling_light(&p, 0.0f, 5.0f, 0.0f, 1.5f, 1);
    p.light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    struct traced t = trace_all(f, &p);
    const struct sparse_list *list = t.samples->lone;
    assert_non_null(list);
    double most = 0, least = 1e30, sum = 0;
    const float *light = lone_values(list, LONE_DIRECT, 0);
    for (uint32_t e = 0; e < list->count; e++) {
        most = fmax(most, (double)light[e]);
        least = fmin(least, (double)light[e]);
        sum += (double)light[e];
    }
    assert_true(sum > 0 && most > 1.5 * least); /* one sample each of a wide light */
    assert_true(fabs(correlation_with_pixels(t.samples, p.sub_samples)) < 0.5);
    p.pattern.seed++;
    struct traced other = trace_all(f, &p);
    uint32_t same = 0;
    for (uint32_t e = 0; e < list->count && e < other.samples->lone->count; e++)
        same += light[e] == lone_values(other.samples->lone, LONE_DIRECT, 0)[e];
    assert_true(same * 20 < list->count);
    traced_fini(&other);
    traced_fini(&t);
    free(f);
}

/* As many samples as a pixel has: the more, the less noise. */
static double noise(uint32_t l)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    p.light_count = 0;
    fixture_ceiling_light(&p, 0.0f, 5.0f, 0.0f, 1.5f, l);
    struct traced t = trace_all(f, &p);
    const struct sparse_list *list = t.samples->lone;
    const float *light = lone_values(list, LONE_DIRECT, 0);
    double sum = 0, squares = 0;
    for (uint32_t e = 0; e < list->count; e++) {
        sum += (double)light[e];
        squares += (double)light[e] * (double)light[e];
    }
    const double mean = sum / list->count;
    const double spread = sqrt(squares / list->count - mean * mean) / mean;
    traced_fini(&t);
    free(f);
    return spread;
}

TEST(more_samples_have_less_noise)
{
    const double one = noise(1), many = noise(6);
    if (!(many < 0.6 * one)) fail_msg("noise is %g with 1 sample and %g with 36", one, many);
}

TEST(stops_when_asked)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = strips_plan(f, 0.5f);
    struct traced t = {0};
    _Atomic bool stop = true;
    open_traced(f, &t);
    assert_int_equal(
        trace_tile(&t, (struct tile_job){.plan = &p, .rect = whole, .stop = &stop}, 0, &t.samples),
        ERR_STATE);
    assert_null(t.samples);
    traced_fini(&t);
    free(f);
}

/* Direct light alone: rows are told of before lone sub-samples are shaded, each sixteen of which
 * are progress, too. */
TEST(progress_goes_on)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = strips_plan(f, 0.5f);
    struct traced t = {0};
    _Atomic uint64_t progress = 0;
    open_traced(f, &t);
    assert_int_equal(trace_tile(&t,
                                (struct tile_job){.plan = &p, .rect = whole, .progress = &progress},
                                0, &t.samples),
                     0);
    assert_true(progress >= (uint64_t)rect_height(whole) + t.samples->lone->count / LANES);
    traced_fini(&t);
    free(f);
}
