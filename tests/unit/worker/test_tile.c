/* The sample loop against closed forms, and against itself over tile sizes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
/* cmocka wants those first */
#include <cmocka.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/tile.h"

static struct scene_fixture *fixture_new(void)
{
    struct scene_fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    return f;
}

struct traced {
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct samples *samples;
    struct counters counters;
};

static struct traced trace(struct scene_fixture *f, const struct plan *plan, struct rect rect)
{
    struct traced t = {0};
    struct fault fault = {0};
    int rc = render_scene_create(fixture_scene(f), 1, &t.scene, &fault);
    if (rc) print_message("%s: %s\n", fault.pointer, fault.detail);
    assert_int_equal(rc, 0);
    assert_int_equal(tile_tracer_create(&t.tracer), 0);
    rc = tile_trace(t.tracer, t.scene, plan, rect, NULL, NULL, &t.samples, &t.counters);
    assert_int_equal(rc, 0);
    return t;
}

static struct traced trace_all(struct scene_fixture *f, const struct plan *plan)
{
    return trace(f, plan, (struct rect){0, 0, plan->width_px, plan->height_px});
}

static void traced_fini(struct traced *t)
{
    samples_destroy(&t->samples);
    tile_tracer_destroy(&t->tracer);
    render_scene_destroy(&t->scene);
}

static uint64_t count(const struct traced *t, enum counter_id id)
{
    return t->counters.value[id];
}

/* A floor at y = 0 seen from above at (0, 4, 0), looking down with z towards the bottom. */
static struct plan floor_plan(struct scene_fixture *f, float half_side, int32_t side_px)
{
    uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    fixture_panel(f, grey, (float[]){0, 0, 0}, (float[]){half_side, 0, 0},
                  (float[]){0, 0, -half_side});
    struct plan p = fixture_plan(side_px, side_px, (float[]){0, 4, 0}, 0.5f);
    fixture_look(&p, (float[]){0, -1, 0}, (float[]){0, 0, -1});
    return p;
}

/* The point that pixel (x, y) of a floor plan sees. */
static void floor_point(const struct plan *p, int32_t x, int32_t y, double out[3])
{
    out[0] = (2.0 * (x + 0.5) / p->width_px - 1.0) * 0.5 * 4.0;
    out[1] = 0.0;
    out[2] = -(1.0 - 2.0 * (y + 0.5) / p->height_px) * 0.5 * 4.0;
}

/* Irradiance of a uniform rectangle of radiance 1 at height h over a floor point, by Lambert's
 * polygon formula: 1/2 sum of edge angles times the normal's part of the edge normals. */
static double polygon_irradiance(const double corners[4][3], const double p[3])
{
    double sum = 0.0, r[4][3];
    for (int i = 0; i < 4; i++) {
        double length = 0.0;
        for (int k = 0; k < 3; k++) r[i][k] = corners[i][k] - p[k];
        for (int k = 0; k < 3; k++) length += r[i][k] * r[i][k];
        for (int k = 0; k < 3; k++) r[i][k] /= sqrt(length);
    }
    for (int i = 0; i < 4; i++) {
        const double *a = r[i], *b = r[(i + 1) % 4];
        double cos = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                       a[0] * b[1] - a[1] * b[0]};
        double length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        sum += acos(cos) * c[1] / length;
    }
    return fabs(0.5 * sum);
}

static void test_rectangle_irradiance(void **state)
{
    (void)state;
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 10.0f, 32);
    fixture_ceiling_light(&p, 0.3f, 2.0f, 0.2f, 0.5f, 32);
    struct traced t = trace_all(f, &p);
    const double corners[4][3] = {{-0.2, 2, -0.3}, {0.8, 2, -0.3}, {0.8, 2, 0.7}, {-0.2, 2, 0.7}};
    const float *e = samples_light_irradiance(t.samples, 0);
    double error = 0.0, mean = 0.0;
    for (int32_t y = 0; y < 32; y++)
        for (int32_t x = 0; x < 32; x++) {
            double point[3];
            floor_point(&p, x, y, point);
            double expected = polygon_irradiance(corners, point);
            double got = (double)e[y * 32 + x];
            assert_true(fabs(got - expected) < 0.03 * expected);
            error += got - expected;
            mean += expected;
        }
    assert_true(fabs(error) < 2e-4 * mean);
    assert_int_equal(count(&t, COUNTER_RAYS_SHADOW), 32 * 32 * 1024);
    assert_int_equal(samples_light_visibility(t.samples, 0, 127)[5], 0xff);
    assert_int_equal(samples_light_slope(t.samples, 0, 0)[5], 0);
    traced_fini(&t);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rectangle_irradiance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
