#pragma once
/* Scenes and plans in which fields bring what diffuse lobes send on. */
#include <stdlib.h>

#include "proto/half.h"
#include "tests/unit/worker/trace/field/lone_strips.h"
#include "worker/scene/lobe_boxes.h"
#include "worker/scene/render_scene.h"

#define PI 3.14159265358979323846

static inline uint32_t coated(struct scene_fixture *f, float roughness, float metallic)
{
    return fixture_glossy(f, (float[]){0.6f, 0.5f, 0.4f}, roughness, metallic);
}

/* Lights' fields beside paths that leave diffuse lobes out. */
static inline void divide(struct plan *p, uint32_t spp)
{
    p->paths.spp = spp;
    p->paths.without_diffuse_direct = 1;
    p->paths.without_diffuse_indirect = p->bounces > 0;
    p->planes |= PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(ALBEDO) | PLANES_CENTRE;
}
