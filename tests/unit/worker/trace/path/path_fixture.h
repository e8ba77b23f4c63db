#pragma once
/* A room for paths, and means of what they bring. */
#include <math.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

static inline void assert_near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance)) print_message("%.9g is not %.9g within %g\n", a, b, tolerance);
    assert_true(fabs(a - b) <= tolerance);
}

#define PATH_BIT(plane) PLANE_BIT(PATH_##plane)

enum { SIDE_PX = 24 };

/* A coloured floor, a mirror-like metal wall, a matt box top and a ceiling light. */
static inline struct plan room(struct scene_fixture *f)
{
    struct plan p = floor_plan(f, 3.0f, SIDE_PX);
    f->materials[0].base_color[1] = 0.25f;
    const uint32_t metal = fixture_glossy(f, (float[]){0.9f, 0.8f, 0.7f}, 0.3f, 1.0f);
    const uint32_t glossy = fixture_glossy(f, (float[]){0.2f, 0.6f, 0.2f}, 0.4f, 0.0f);
    fixture_panel(f, metal, (float[]){-2, 1, 0}, (float[]){0, 0, -1}, (float[]){0, 1, 0});
    fixture_panel(f, glossy, (float[]){1, 0.5f, 0}, (float[]){0.5f, 0, 0}, (float[]){0, 0, -0.5f});
    fixture_ceiling_light(&p, 0, 3, 0, 0.5f, 1);
    p.lights[0].color[1] = 0.5f;
    p.light_planes = 0;
    p.planes = PLANES_PATH & ~PATH_BIT(VISIBILITY);
    p.bounces = 3;
    p.paths.spp = 16;
    return p;
}

static inline float *plane(const struct traced *t, enum plane_id id, uint32_t c)
{
    float *v = samples_f32(t->samples, id, c);
    assert_non_null(v);
    return v;
}

static inline double mean(const struct traced *t, enum plane_id id, uint32_t c, uint32_t spp)
{
    double sum = 0;
    const float *v = plane(t, id, c);
    int32_t area = t->samples->layout.width_px * t->samples->layout.height_px;
    for (int32_t i = 0; i < area; i++) sum += (double)v[i];
    return sum / area / spp;
}

static inline struct samples *trace_pass(struct traced *t, const struct plan *p, uint32_t pass)
{
    struct samples *s = NULL;
    struct rect all = {0, 0, SIDE_PX, SIDE_PX};
    assert_int_equal(trace_tile(t, (struct tile_job){.plan = p, .rect = all}, pass, &s), 0);
    return s;
}

static inline void expect_equal_light(const struct traced *a, const struct traced *b,
                                      enum plane_id plane, uint32_t spp)
{
    for (uint32_t c = 0; c < 3; c++) {
        const double spread = mean(a, PLANE_PATH_M2, c, spp) + mean(b, PLANE_PATH_M2, c, spp);
        assert_near(mean(a, plane, c, spp), mean(b, plane, c, spp),
                    4 * sqrt(spread / ((double)spp * SIDE_PX * SIDE_PX)));
    }
}
