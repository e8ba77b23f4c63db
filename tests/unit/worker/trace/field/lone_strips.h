#pragma once
/* Thin strips above a floor, whose sub-samples are lone. */
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#define SIDE 32

static const struct rect whole = {0, 0, SIDE, SIDE};

/* Strips of a fifth of a pixel, leaning, half-way between the floor and the camera; a pixel is 1/16
 * wide there. */
static inline void add_strips(struct scene_fixture *f, uint32_t material)
{
    for (int i = 0; i < 9; i++) {
        const float x = -0.93f + 0.2131f * (float)i;
        const float lean = 0.05f * sinf(3.0f * (float)i);
        fixture_panel(f, material, (float[]){x, 2.0f, 0}, (float[]){0.00625f, 0, 0},
                      (float[]){lean, 0, -0.9f});
    }
}

/* The floor under strips, lit by a bulb. */
static inline struct plan strips_plan(struct scene_fixture *f, float albedo)
{
    struct plan p = floor_plan(f, 4, SIDE);
    add_strips(f, fixture_material(f, albedo, albedo, albedo));
    struct plan_light *light = fixture_light(&p, LIGHT_POINT, 1);
    memcpy(light->position, (float[]){0.3f, 5.0f, 0.2f}, sizeof light->position);
    memcpy(light->color, (float[]){3, 5, 7}, sizeof light->color);
    p.sub_samples = 3;
    p.planes = PLANES_COMPARED | PLANE_BIT(ALBEDO) | PLANE_BIT(LONE);
    p.light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    return p;
}
