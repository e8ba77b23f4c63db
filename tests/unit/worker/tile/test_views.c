/* Views of a plan: which objects each shows, and that what no object reaches is the same to the
 * bit with and without it. */
#include <math.h>
#include <string.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

enum { SIDE = 32 };

/* A floor that catches, a small panel above its middle that is virtual, and one to the left of it
 * that holds out; a light straight above that has no size. */
static struct plan views_plan(struct scene_fixture *f, uint32_t bounces)
{
    struct plan p = floor_plan(f, 2.0f, SIDE);
    const uint32_t red = fixture_material(f, 0.8f, 0.1f, 0.1f);
    const uint32_t object = fixture_panel(f, red, (float[]){0.5f, 0.5f, 0}, (float[]){0, 0, 0.3f},
                                          (float[]){0.3f, 0, 0});
    const uint32_t holdout = fixture_panel(f, red, (float[]){-1.2f, 0.5f, 0}, (float[]){0, 0, 0.3f},
                                           (float[]){0.3f, 0, 0});
    for (uint32_t i = 0; i < object; i++) f->instances[i].flags |= INSTANCE_CATCHER;
    f->instances[holdout].flags |= INSTANCE_HOLDOUT;
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    memcpy(sun->direction, (float[]){0, -1, 0}, sizeof sun->direction);
    p.planes = PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(PATH_COVERAGE) | PLANE_BIT(PATH_INDIRECT);
    p.light_planes = p.sub_samples = 0;
    p.paths.spp = 16;
    p.bounces = bounces;
    p.capabilities |= CAPABILITY_PATHS | CAPABILITY_VIEWS;
    p.composite = 1;
    return p;
}

static struct samples *trace_view(struct traced *t, const struct plan *p, enum plan_view view)
{
    struct samples *samples = NULL;
    const struct tile_job job = {.plan = p, .rect = {0, 0, SIDE, SIDE}};
    assert_int_equal(trace_tile(t, job, view, &samples), 0);
    return samples;
}

/* The pixel that shows a point of the floor. */
static size_t pixel_at(const struct plan *p, double x, double z)
{
    size_t best = 0;
    double least = INFINITY;
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        double at[3];
        floor_point(p, i % SIDE, i / SIDE, at);
        const double far = hypot(at[0] - x, at[2] - z);
        if (far < least) least = far, best = (size_t)i;
    }
    return best;
}

TEST(each_view_shows_its_part)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = views_plan(f, 0);
    struct traced t = {0};
    open_traced(f, &t);
    struct samples *views[PLAN_VIEWS];
    const float *coverage[PLAN_VIEWS], *light[PLAN_VIEWS];
    for (int k = 0; k < (int)PLAN_VIEWS; k++) {
        views[k] = trace_view(&t, &p, (enum plan_view)k);
        coverage[k] = samples_f32(views[k], PLANE_PATH_COVERAGE, 0);
        light[k] = samples_f32(views[k], PLANE_PATH_RADIANCE, 0);
    }
    /* What lies half as high is seen closer to the middle than the floor below it. */
    const size_t object = pixel_at(&p, 0.57, 0), holdout = pixel_at(&p, -1.37, 0),
                 shadow = pixel_at(&p, 0.5, 0), open = pixel_at(&p, 0, 1.5);
    assert_true(coverage[PLAN_VIEW_OBJECTS][object] == 16.0f);
    assert_true(light[PLAN_VIEW_OBJECTS][object] > 0.0f);
    assert_true(coverage[PLAN_VIEW_OBJECTS][open] == 0.0f);
    assert_true(light[PLAN_VIEW_OBJECTS][open] == 0.0f);
    for (int k = PLAN_VIEW_WITH; k <= PLAN_VIEW_WITHOUT; k++) {
        assert_true(coverage[k][object] == 16.0f && coverage[k][open] == 16.0f);
        assert_true(coverage[k][holdout] == 0.0f && light[k][holdout] == 0.0f);
    }
    assert_true(light[PLAN_VIEW_WITH][shadow] == 0.0f);
    assert_true(light[PLAN_VIEW_WITHOUT][shadow] > 0.0f);
    for (int k = 0; k < (int)PLAN_VIEWS; k++) samples_destroy(&views[k]);
    traced_fini(&t);
}

/* Every pixel whose paths met no object has the same bits. Without bounces these are all but those
 * in the shadow; with bounces some others change, and many do not. */
TEST(what_no_object_reaches_has_the_same_bits)
{
    for (uint32_t bounces = 0; bounces < 3; bounces += 2) {
        struct scene_fixture *f = fixture_new();
        const struct plan p = views_plan(f, bounces);
        struct traced t = {0};
        open_traced(f, &t);
        struct samples *with = trace_view(&t, &p, PLAN_VIEW_WITH),
                       *without = trace_view(&t, &p, PLAN_VIEW_WITHOUT);
        const float *a = samples_f32(with, PLANE_PATH_RADIANCE, 0),
                    *b = samples_f32(without, PLANE_PATH_RADIANCE, 0);
        uint32_t same = 0, far_same = 0, far = 0;
        for (int32_t i = 0; i < SIDE * SIDE; i++) {
            double at[3];
            floor_point(&p, i % SIDE, i / SIDE, at);
            const bool is_far = fabs(at[0] - 0.5) > 0.5 || fabs(at[2]) > 0.5;
            far += is_far;
            same += memcmp(&a[i], &b[i], sizeof *a) == 0;
            far_same += is_far && memcmp(&a[i], &b[i], sizeof *a) == 0;
        }
        if (bounces == 0) assert_int_equal(far_same, far);
        assert_true(far_same > far / 2);
        assert_true(same < SIDE * SIDE);
        samples_destroy(&with);
        samples_destroy(&without);
        traced_fini(&t);
    }
}

/* Blocks beside the boxes of virtual objects are not traced: to the bit as if they were, for fewer
 * rays. A lens may blur an object over pixels that its box does not cover. */
TEST(pixels_beside_objects_are_not_traced)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = views_plan(f, 2);
    struct traced t = {0};
    open_traced(f, &t);
    for (int kind = 0; kind < 3; kind++) {
        const bool lens = kind == 1, open = kind == 2;
        p.camera.aperture_radius = lens ? 0.3f : 0.0f;
        p.occlusion_distance = open ? 1.0f : 0.0f;
        if (open) p.planes |= PLANE_BIT(PATH_VISIBILITY);
        p.camera.focus_distance = 1.0f;
        struct lobe_boxes *const boxes = t.scene->virtuals;
        assert_non_null(boxes);
        uint64_t before = count(&t, COUNTER_PATHS);
        struct samples *some = trace_view(&t, &p, PLAN_VIEW_OBJECTS);
        const uint64_t few = count(&t, COUNTER_PATHS) - before;
        t.scene->virtuals = NULL;
        before = count(&t, COUNTER_PATHS);
        struct samples *all = trace_view(&t, &p, PLAN_VIEW_OBJECTS);
        const uint64_t many = count(&t, COUNTER_PATHS) - before;
        t.scene->virtuals = boxes;
        assert_memory_equal(some->data, all->data, some->layout.total_bytes);
        if (lens || open)
            assert_true(few == many);
        else
            assert_true(few > 0 && few < many / 2);
        samples_destroy(&some);
        samples_destroy(&all);
    }
    traced_fini(&t);
}

/* A frame's views do not mask rays of the next frame. */
TEST(an_ordinary_plan_sees_all_again)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = views_plan(f, 1), one = plan_of_view(&p);
    struct traced t = {0};
    open_traced(f, &t);
    struct samples *before = trace_view(&t, &one, 0), *view = trace_view(&t, &p, PLAN_VIEW_WITHOUT),
                   *after = trace_view(&t, &one, 0);
    assert_memory_equal(before->data, after->data, before->layout.total_bytes);
    samples_destroy(&before);
    samples_destroy(&view);
    samples_destroy(&after);
    traced_fini(&t);
}
