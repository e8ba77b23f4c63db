#pragma once
/* A plan of a scene's default camera and lights, for benchmarks that trace without a coordinator.
 */
#include <math.h>
#include <string.h>

#include "proto/samples.h"
#include "proto/scene/scene.h"

enum { SIDE_PX = 720, TILE_PX = 64, STRATA = 3 };

static float extent(const struct scene *s)
{
    float sum = 0.0f;
    for (int i = 0; i < 3; i++) {
        float side = s->info->bounds_max[i] - s->info->bounds_min[i];
        sum += side * side;
    }
    return sqrtf(sum);
}

/* A square light up and to the camera's side of a scene that has none. */
static void add_light(const struct scene *s, struct plan *p)
{
    float size = extent(s), length = 0.0f;
    struct plan_light *light = &p->lights[p->light_count++];
    *light = (struct plan_light){.type = LIGHT_RECTANGLE, .color = {1, 1, 1}, .power = 1.0f};
    for (int i = 0; i < 3; i++) {
        float up = p->camera.up[i], back = -p->camera.forward[i], right = p->camera.right[i];
        float centre = 0.5f * (s->info->bounds_min[i] + s->info->bounds_max[i]);
        float way = 0.8f * up + 0.6f * back + 0.3f * right;
        light->position[i] = centre + size * way;
        light->direction[i] = -way;
        length += way * way;
        light->half_u[i] = right;
    }
    float *n = light->direction, *u = light->half_u, *v = light->half_v, along = 0.0f, side = 0.0f;
    for (int i = 0; i < 3; i++) n[i] /= sqrtf(length);
    for (int i = 0; i < 3; i++) along += u[i] * n[i];
    for (int i = 0; i < 3; i++) u[i] -= along * n[i];
    for (int i = 0; i < 3; i++) side += u[i] * u[i];
    for (int i = 0; i < 3; i++) u[i] *= 0.1f * size / sqrtf(side);
    v[0] = n[1] * u[2] - n[2] * u[1];
    v[1] = n[2] * u[0] - n[0] * u[2];
    v[2] = n[0] * u[1] - n[1] * u[0];
}

static void add_scene_lights(const struct scene *s, struct plan *p)
{
    for (uint64_t i = 0; i < s->count[SCENE_LIGHTS] && p->light_count < LIMIT_LIGHTS; i++) {
        const struct scene_light *from = &s->lights[i];
        struct plan_light *to = &p->lights[p->light_count++];
        to->type = from->type;
        to->profile = from->profile;
        memcpy(to->position, from->position, sizeof to->position);
        memcpy(to->direction, from->direction, sizeof to->direction);
        memcpy(to->half_u, from->half_u, sizeof to->half_u);
        memcpy(to->half_v, from->half_v, sizeof to->half_v);
        memcpy(to->color, from->color, sizeof to->color);
        to->cos_inner = from->cos_inner;
        to->cos_outer = from->cos_outer;
        to->range = from->range;
        to->power = 1.0f;
    }
    if (p->light_count == 0) add_light(s, p);
    for (uint32_t i = 0; i < p->light_count; i++)
        p->lights[i].strata_per_axis = p->lights[i].type == LIGHT_RECTANGLE ? STRATA : 1;
}

static void plan_init(const struct scene *s, struct plan *p)
{
    const struct scene_camera *c = &s->cameras[s->info->default_camera];
    *p = (struct plan){.width_px = SIDE_PX, .height_px = SIDE_PX, .tile_px = TILE_PX};
    p->pattern.seed = 1;
    p->camera.type = c->type;
    memcpy(p->camera.eye, c->eye, sizeof c->eye);
    memcpy(p->camera.right, c->right, sizeof c->right);
    memcpy(p->camera.up, c->up, sizeof c->up);
    memcpy(p->camera.forward, c->forward, sizeof c->forward);
    p->camera.half_height =
        c->type == CAMERA_ORTHOGRAPHIC ? c->half_height : tanf(0.5f * c->yfov_rad);
    p->camera.half_width = p->camera.half_height;
    add_scene_lights(s, p);
    p->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ALBEDO) | PLANE_BIT(ID);
    p->light_planes = 1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_VISIBILITY;
    p->radiance_scale = 1.0f;
    p->mu = 1.0f;
    p->length_unit = exp2f(ceilf(log2f(0.5f * extent(s))));
}
