/* Later passes and second sets of bounce rays: each brings the same light on the average. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_room.h"

/* Passes after the schedule: paths go on where they were, bounce rays start anew, and each brings
 * the same light on the average. */
TEST(later_passes_go_on)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, LAMBERT, SHINES_RECT);
    add_field(&p, 4);
    p.planes = (p.planes & ~BIT(INDIRECT_MEAN)) | BIT(INDIRECT_HALVES) | BIT(PATH_M2) |
               BIT(PATH_HALF_DIFFERENCE2);
    p.paths.spp = 16;
    p.bounces = 2;
    p.target_error = 0.1f;
    p.spp_max = 1024;
    const struct plan without = p; /* its pass has no bounce rays */
    struct fault fault = {0};
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct counters counters = {0};
    const struct rect all = {0, 0, SIDE_PX, SIDE_PX}, part = {3, 1, SIDE_PX - 2, SIDE_PX};
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    const struct plan_pass start = {0, 0, 16, 4, NULL, NULL}, pass = {1, 16, 16, 8, NULL, NULL},
                           next = {1, 16, 16, 0, NULL, NULL};
    struct samples *first, *more, *cut, *alone;
#define TRACE(its_plan, its_pass, its_rect, out)                                                   \
    assert_int_equal(tile_trace_pass(tracer,                                                       \
                                     &(struct tile_job){.scene = scene,                            \
                                                        .plan = its_plan,                          \
                                                        .pass = its_pass,                          \
                                                        .rect = its_rect,                          \
                                                        .counters = &counters},                    \
                                     out),                                                         \
                     0)
    TRACE(&p, &start, all, &first);
    TRACE(&p, &pass, all, &more);
    TRACE(&p, &pass, part, &cut);
    TRACE(&without, &next, all, &alone);
#undef TRACE
    assert_int_equal(more->layout.planes,
                     BIT(INDIRECT_HALVES) | BIT(BOUNCE_DISTANCE_MIN) | (p.planes & PLANES_PATH));
    for (uint32_t c = 0; c < 3; c++) {
        double sums[2] = {0, 0};
        uint32_t equal = 0;
        assert_memory_equal(samples_f32(more, PLANE_PATH_RADIANCE, c),
                            samples_f32(alone, PLANE_PATH_RADIANCE, c), AREA * sizeof(float));
        for (int i = 0; i < AREA; i++) {
            const uint16_t a = samples_u16(first, PLANE_INDIRECT_HALVES, c)[i];
            const uint16_t b = samples_u16(more, PLANE_INDIRECT_HALVES, c)[i];
            sums[0] += (double)half_to_float(a);
            sums[1] += (double)half_to_float(b);
            equal += a == b && a != 0;
        }
        assert_true(fabs(sums[0] - sums[1]) < 0.1 * sums[1] && equal < AREA / 10);
    }
    for (int32_t y = part.y0; y < part.y1; y++)
        for (int32_t x = part.x0; x < part.x1; x++) {
            const int32_t i = y * SIDE_PX + x, k = (y - part.y0) * rect_width(part) + x - part.x0;
            assert_int_equal(samples_u16(more, PLANE_INDIRECT_HALVES, 4)[i],
                             samples_u16(cut, PLANE_INDIRECT_HALVES, 4)[k]);
            assert_true(samples_f32(more, PLANE_PATH_HALF_DIFFERENCE2, 0)[i] ==
                        samples_f32(cut, PLANE_PATH_HALF_DIFFERENCE2, 0)[k]);
        }
    struct samples **const made[] = {&first, &more, &cut, &alone};
    for (int k = 0; k < 4; k++) samples_destroy(made[k]);
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&scene);
    free(f);
}

static double plane_mean(const struct samples *s, enum plane_id plane)
{
    double sum = 0;
    for (int i = 0; i < AREA; i++) sum += (double)half_to_float(samples_u16(s, plane, 0)[i]);
    return sum / AREA;
}

/* A second set: each pixel's rays are its own, whatever the tile and the pixels beside it; pixels
 * without any are skipped, and all bring the same light on the average as the first set. */
TEST(second_sets_are_of_each_pixel)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, COATED, SHINES_RECT | SHINES_SKY);
    add_field(&p, 4);
    p.planes |= BIT(BOUNCE_DISTANCE_MAX);
    p.bounces = 2;
    p.indirect_filter = INDIRECT_FILTER_ADAPTIVE;
    p.adaptive = (struct plan_adaptive){.mu = 1, .rays_max = 1000};
    struct fault fault = {0};
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct counters counters = {0}, alike = {0};
    const uint32_t last = plan_pass_count(&p);
    const struct rect all = {0, 0, SIDE_PX, SIDE_PX}, part = {3, 1, SIDE_PX - 2, SIDE_PX};
    uint8_t mixed[AREA], equal[AREA], cut_map[AREA], wrong[AREA];
    for (int i = 0; i < AREA; i++) {
        equal[i] = 7;
        wrong[i] = 6;
        mixed[i] = (uint8_t)(i % 3 == 0 ? 7 : i % 3 == 1 ? 5 : 0);
    }
    for (int32_t y = part.y0, k = 0; y < part.y1; y++)
        for (int32_t x = part.x0; x < part.x1; x++) cut_map[k++] = mixed[y * SIDE_PX + x];
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    struct samples *first, *more, *cut, *whole;
    const struct plan_pass start = plan_scheduled_pass(&p, 0);
    const struct plan_pass second = {.number = last, .strata = 7, .strata_map = mixed},
                           same = {.number = last, .strata = 7, .strata_map = equal},
                           in_part = {.number = last, .strata = 7, .strata_map = cut_map},
                           bad = {.number = last, .strata = 7, .strata_map = wrong};
#define TRACE(its_pass, its_rect, out, count)                                                      \
    tile_trace_pass(                                                                               \
        tracer,                                                                                    \
        &(struct tile_job){                                                                        \
            .scene = scene, .plan = &p, .pass = its_pass, .rect = its_rect, .counters = count},    \
        out)
    assert_int_equal(TRACE(&start, all, &first, &(struct counters){{0}}), 0);
    assert_int_equal(TRACE(&second, all, &more, &counters), 0);
    assert_int_equal(TRACE(&same, all, &whole, &alike), 0);
    assert_int_equal(TRACE(&in_part, part, &cut, &(struct counters){{0}}), 0);
    struct samples *none = NULL;
    assert_int_equal(TRACE(&bad, all, &none, &(struct counters){{0}}), ERR_RANGE);
#undef TRACE
    assert_int_equal(more->layout.planes, BIT(INDIRECT_MEAN));
    assert_int_equal(counters.value[COUNTER_SKIPPED_ENOUGH], AREA / 3);
    assert_int_equal(alike.value[COUNTER_SKIPPED_ENOUGH], 0);
    assert_true(counters.value[COUNTER_RAYS_INDIRECT] < alike.value[COUNTER_RAYS_INDIRECT]);
    assert_int_equal(counters.value[COUNTER_RAYS_ANTIALIAS] + counters.value[COUNTER_PATHS], 0);
    for (int i = 0; i < AREA; i++)
        for (uint32_t c = 0; c < 3; c++) {
            const uint16_t value = samples_u16(more, PLANE_INDIRECT_MEAN, c)[i];
            if (mixed[i] == 0) assert_int_equal(value, 0);
            if (mixed[i] == 7)
                assert_int_equal(value, samples_u16(whole, PLANE_INDIRECT_MEAN, c)[i]);
        }
    for (int32_t y = part.y0; y < part.y1; y++)
        for (int32_t x = part.x0; x < part.x1; x++) {
            const int32_t k = (y - part.y0) * rect_width(part) + x - part.x0;
            assert_int_equal(samples_u16(more, PLANE_INDIRECT_MEAN, 1)[y * SIDE_PX + x],
                             samples_u16(cut, PLANE_INDIRECT_MEAN, 1)[k]);
        }
    const double of_first = plane_mean(first, PLANE_INDIRECT_MEAN);
    assert_true(fabs(plane_mean(whole, PLANE_INDIRECT_MEAN) - of_first) < 0.1 * of_first);
    /* farthest hits are no nearer than the nearest, and there where something was met */
    for (int i = 0; i < AREA; i++) {
        const float near = half_to_float(samples_u16(first, PLANE_BOUNCE_DISTANCE_MIN, 0)[i]);
        const float far = half_to_float(samples_u16(first, PLANE_BOUNCE_DISTANCE_MAX, 0)[i]);
        assert_true(near == BOUNCE_DISTANCE_NONE ? far == 0.0f : far >= near);
    }
    assert_true(plane_mean(first, PLANE_BOUNCE_DISTANCE_MAX) >
                1.5 * plane_mean(first, PLANE_BOUNCE_DISTANCE_MIN));
    struct samples **const made[] = {&first, &more, &cut, &whole};
    for (int k = 0; k < 4; k++) samples_destroy(made[k]);
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&scene);
    free(f);
}
