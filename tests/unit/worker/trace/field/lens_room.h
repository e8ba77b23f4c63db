#pragma once
/* What tests of lens samples look at: a room's corner through a lens. */
#include "proto/half.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

/* A plan of lens samples alone, from the origin along -z, focused on z = 4. */
static inline struct plan lens_plan(int32_t side_px, uint32_t l)
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
static inline void add_lamp(struct scene_fixture *f, float x, float y, float z, float half,
                            const float color[3])
{
    const uint32_t black = fixture_material(f, 0, 0, 0);
    memcpy(f->materials[black].emission, color, sizeof f->materials[black].emission);
    fixture_panel(f, black, (float[]){x, y, -z}, (float[]){half, 0, 0}, (float[]){0, half, 0});
}

static inline float value(const struct traced *t, enum plane_id plane, uint32_t component, size_t i)
{
    if (plane == PLANE_LENS_RADIANCE) return samples_f32(t->samples, plane, component)[i];
    return half_to_float(samples_u16(t->samples, plane, component)[i]);
}

static inline void expect_near(double is, double should, double tolerance)
{
    if (!(fabs(is - should) <= tolerance)) fail_msg("%g is not %g", is, should);
}

/* A room's corner with a lamp, out of focus at both ends. */
static inline void add_room(struct scene_fixture *f, struct plan *p)
{
    const uint32_t grey = fixture_material(f, 0.7f, 0.6f, 0.5f);
    fixture_panel(f, grey, (float[]){0, -0.5f, -6}, (float[]){6, 0, 0}, (float[]){0, 0, -6});
    fixture_panel(f, grey, (float[]){0, 0, -9}, (float[]){6, 0, 0}, (float[]){0, 6, 0});
    fixture_panel(f, grey, (float[]){0.3f, 0, -2.5f}, (float[]){0.3f, 0, 0}, (float[]){0, 0.3f, 0});
    add_lamp(f, -0.5f, 0.5f, 3, 0.25f, (float[]){4, 5, 6});
    fixture_ceiling_light(p, 0, 3, -4, 0.5f, 1);
    p->bounces = 2;
}
