#include "tests/unit/server/reconstruct/filtered_case.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "tests/unit/server/reconstruct/film_picture.h"

void filtered_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                   uint32_t filter, uint32_t lights)
{
    memset(plan, 0, sizeof *plan);
    plan->width_px = width;
    plan->height_px = height;
    plan->tile_px = tile_px;
    plan->pattern = (struct pattern){5, 1};
    plan->camera = (struct plan_camera){.type = CAMERA_PERSPECTIVE,
                                        .eye = {0, 6, 4},
                                        .right = {1, 0, 0},
                                        .up = {0, 0.6f, -0.8f},
                                        .forward = {0, -0.8f, -0.6f},
                                        .half_width = 0.7f * (float)width / (float)height,
                                        .half_height = 0.7f};
    plan->light_count = lights;
    for (uint32_t k = 0; k < lights; k++) {
        bool point = k % 2;
        plan->lights[k] = (struct plan_light){.type = point ? LIGHT_POINT : LIGHT_RECTANGLE,
                                              .position = {(float)k, 4, 0},
                                              .direction = {0, -1, 0},
                                              .half_u = {0.4f + 0.2f * (float)k, 0, 0},
                                              .half_v = {0, 0, 0.5f},
                                              .color = {8, 7, 6},
                                              .power = 1,
                                              .strata_per_axis = point ? 1 : 3};
    }
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ALBEDO) | PLANE_BIT(ID) |
                   PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |
                   PLANE_BIT(SUB_ID);
    plan->light_planes =
        1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES;
    plan->sub_samples = LIMIT_SUB_SAMPLES;
    plan->radiance_scale = 4.0f;
    plan->length_unit = 8.0f;
    plan->shadow_filter = filter;
    plan->mu = 1.0f;
}

/* Distance to the floor along the ray through a pixel position; 0: none. */
static float filtered_look(const struct plan *plan, float px, float py, float point[3])
{
    float origin[3], direction[3];
    plan_camera_ray(plan, px, py, origin, direction);
    if (!(direction[1] < -1e-3f)) return 0.0f;
    float distance = -origin[1] / direction[1];
    for (int i = 0; i < 3; i++) point[i] = origin[i] + distance * direction[i];
    point[1] = 0.0f;
    return point[0] < -4.0f ? 0.0f : distance;
}

static void filtered_put_light(struct samples *s, const struct plan *plan,
                               const struct filtered_world *world, uint32_t k, int32_t x, int32_t y,
                               size_t i, const float point[3])
{
    const struct plan_light *light = &plan->lights[k];
    uint32_t l = light->strata_per_axis;
    float jitter[2], least = 0, most = 0, irradiance = 0;
    pattern_jitter(&plan->pattern, x, y, pattern_light_dimension(k, l), jitter);
    for (uint32_t n = 0; n < l * l; n++) {
        bool area = light->type == LIGHT_RECTANGLE;
        float u = area ? 2 * pattern_axis(jitter[0], l, n % l) - 1 : 0;
        float v = area ? 2 * pattern_axis(jitter[1], l, n / l) - 1 : 0;
        float at[3], w[3], t = world->shelf_height / light->position[1];
        for (int c = 0; c < 3; c++) {
            at[c] = light->position[c] + u * light->half_u[c] + v * light->half_v[c];
            w[c] = at[c] - point[c];
        }
        bool blocked = world->shelf_half > 0 && fabsf(point[0] + t * w[0]) <= world->shelf_half &&
                       point[2] + t * w[2] <= 0;
        uint8_t *bits = samples_light_visibility(s, k, n >> 3);
        if (bits && !blocked) bits[i] = (uint8_t)(bits[i] | 1u << (n & 7));
        float slope = t / (1 - t), d2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        if (blocked) {
            least = most > 0 ? fminf(least, slope) : slope;
            most = fmaxf(most, slope);
        }
        float size = area ? 4 * light->half_u[0] * light->half_v[2] * w[1] / d2 : 1 / sqrtf(d2);
        irradiance += blocked ? 0 : size * w[1] / d2 / (float)(l * l);
    }
    if (samples_light_irradiance(s, k)) samples_light_irradiance(s, k)[i] = irradiance;
    if (!samples_light_slope(s, k, 0)) return;
    samples_light_slope(s, k, 0)[i] = half_from_float(least);
    samples_light_slope(s, k, 1)[i] = half_from_float(most);
}

/* Where there is no surface nothing was traced: all strata count as seen. */
static void filtered_put_miss(struct samples *s, const struct plan *plan, uint32_t k, size_t i)
{
    uint32_t strata = plan->lights[k].strata_per_axis * plan->lights[k].strata_per_axis;
    for (uint32_t n = 0; n < strata; n++) {
        uint8_t *bits = samples_light_visibility(s, k, n >> 3);
        if (bits) bits[i] = (uint8_t)(bits[i] | 1u << (n & 7));
    }
}

void filtered_put(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t i,
                  const void *world)
{
    const float up[3] = {0, 1, 0};
    float point[3], other[3];
    float depth = filtered_look(plan, (float)x + 0.5f, (float)y + 0.5f, point);
    bool hit = depth > 0.0f;
    samples_f32(s, PLANE_DEPTH, 0)[i] = depth;
    samples_u32(s, PLANE_NORMAL, 0)[i] = hit ? octahedron_pack16(up) : 0;
    samples_u32(s, PLANE_ID, 0)[i] = hit;
    for (uint32_t c = 0; c < 3; c++) samples_u16(s, PLANE_ALBEDO, c)[i] = hit ? 32768 : 0;
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        float at[2];
        pattern_pixel(&plan->pattern, x, y, k, plan->sub_samples, at);
        float sub = filtered_look(plan, (float)x + at[0], (float)y + at[1], other);
        float reference = hit ? depth : plan->length_unit;
        samples_u16(s, PLANE_SUB_DEPTH, k)[i] =
            half_from_float(sub > 0 ? sub / reference - 1 : SUB_DEPTH_MISS);
        samples_u16(s, PLANE_SUB_ID, k)[i] = sub > 0;
        samples_u16(s, PLANE_SUB_NORMAL, k)[i] = sub > 0 ? octahedron_pack8(up) : 0;
        for (uint32_t c = 0; c < 3; c++)
            samples_u16(s, PLANE_SUB_ALBEDO, k * 3 + c)[i] = sub > 0 ? 32768 : 0;
    }
    for (uint32_t k = 0; k < plan->light_count; k++) {
        if (hit)
            filtered_put_light(s, plan, world, k, x, y, i, point);
        else
            filtered_put_miss(s, plan, k, i);
    }
}

struct samples *filtered_tile(const struct plan *plan, const struct filtered_world *world,
                              uint32_t tile)
{
    return picture_tile(plan, tile, filtered_put, world);
}
