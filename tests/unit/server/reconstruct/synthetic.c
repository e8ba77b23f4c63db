#include "tests/unit/server/reconstruct/synthetic.h"

#include <math.h>
#include <string.h>

#include "tests/unit/server/reconstruct/film_picture.h"

void synthetic_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px)
{
    memset(plan, 0, sizeof *plan);
    plan->width_px = width;
    plan->height_px = height;
    plan->tile_px = tile_px;
    plan->pattern = (struct pattern){1, 1};
    plan->camera = (struct plan_camera){.type = CAMERA_PERSPECTIVE,
                                        .right = {1, 0, 0},
                                        .up = {0, 1, 0},
                                        .forward = {0, 0, -1},
                                        .half_width = 0.5f * (float)width / (float)height,
                                        .half_height = 0.5f};
    plan->light_count = 1;
    plan->lights[0] = (struct plan_light){.type = LIGHT_RECTANGLE,
                                          .direction = {0, -1, 0},
                                          .half_u = {1, 0, 0},
                                          .half_v = {0, 0, 1},
                                          .color = {1, 1, 1},
                                          .power = 1,
                                          .strata_per_axis = 3};
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ALBEDO) | PLANE_BIT(ID) |
                   PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |
                   PLANE_BIT(SUB_ID) | PLANE_BIT(EMISSION) | PLANE_BIT(INDIRECT_MEAN);
    plan->light_planes =
        1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES;
    plan->sub_samples = 3;
    plan->bounces = 1;
    plan->indirect_strata_per_axis = 3;
    plan->radiance_scale = 4.0f;
    plan->length_unit = 8.0f;
    plan->mu = 1.0f;
}

struct synthetic_pixel synthetic_pixel(const struct plan *plan, int32_t x, int32_t y)
{
    struct synthetic_pixel p = {0};
    bool hole = (x + y) % 11 == 0;
    float fx = (float)x, fy = (float)y;
    const float n[3] = {0.1f * sinf(fx), 1.0f, 0.3f};
    float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    p.depth = hole ? 0.0f : 5.0f + 0.01f * fx + 0.02f * fy;
    for (int c = 0; c < 3; c++) {
        p.normal[c] = hole ? 0.0f : n[c] / length;
        p.albedo[c] = 0.2f + 0.1f * (float)((x * 3 + y + c) % 7);
        p.indirect[c] = 0.5f + 0.1f * (float)((x + y * 5 + c) % 9);
    }
    p.bounce_distance_min =
        hole ? 0.0f : plan->length_unit * 0.125f * (float)(1 + (x * 7 + y * 3) % 5);
    p.open = hole ? 0.0f : 0.125f * (float)((x + 2 * y) % 9);
    p.id = hole ? 0 : (uint32_t)(1 + x / 4 + y / 4 * 70000);
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        float reference = hole ? plan->length_unit : p.depth;
        p.sub_depth[k] = reference * (1.0f + 0.01f * (float)k);
    }
    p.irradiance = 1.0f + 0.25f * fx + 0.5f * fy;
    p.visibility = (uint32_t)(x * 37 + y * 11) & 511u;
    return p;
}

uint16_t synthetic_sub_id(uint32_t id)
{
    uint16_t low = (uint16_t)(id & 0xffffu);
    return id != 0 && low == 0 ? 0xffffu : low;
}

void synthetic_put_bounces(struct samples *s, const struct plan *plan, size_t i,
                           const struct synthetic_pixel *p)
{
    if (plan->planes >> PLANE_BOUNCE_DISTANCE_MIN & 1u)
        samples_u16(s, PLANE_BOUNCE_DISTANCE_MIN, 0)[i] =
            half_from_float(p->bounce_distance_min / plan->length_unit);
    if (plan->planes >> PLANE_BOUNCE_DISTANCE_MAX & 1u)
        samples_u16(s, PLANE_BOUNCE_DISTANCE_MAX, 0)[i] =
            half_from_float(4.0f * p->bounce_distance_min / plan->length_unit);
    if (plan->planes >> PLANE_AMBIENT_VISIBILITY & 1u)
        samples_u16(s, PLANE_AMBIENT_VISIBILITY, 0)[i] = half_from_float(p->open);
}

void synthetic_put(struct samples *s, const struct plan *plan, size_t i,
                   const struct synthetic_pixel *p)
{
    samples_f32(s, PLANE_DEPTH, 0)[i] = p->depth;
    samples_u32(s, PLANE_NORMAL, 0)[i] = p->depth > 0.0f ? octahedron_pack16(p->normal) : 0;
    samples_u32(s, PLANE_ID, 0)[i] = p->id;
    for (uint32_t c = 0; c < 3; c++) {
        samples_u16(s, PLANE_ALBEDO, c)[i] = (uint16_t)lrintf(p->albedo[c] * 65535.0f);
        if (plan->planes >> PLANE_INDIRECT_MEAN & 1u)
            samples_u16(s, PLANE_INDIRECT_MEAN, c)[i] =
                half_from_float(p->indirect[c] * plan->radiance_scale);
    }
    synthetic_put_bounces(s, plan, i, p);
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        float reference = p->depth > 0.0f ? p->depth : plan->length_unit;
        samples_u16(s, PLANE_SUB_DEPTH, k)[i] = half_from_float(p->sub_depth[k] / reference - 1.0f);
        samples_u16(s, PLANE_SUB_ID, k)[i] = synthetic_sub_id(p->id);
        samples_u16(s, PLANE_SUB_NORMAL, k)[i] = p->depth > 0.0f ? octahedron_pack8(p->normal) : 0;
        for (uint32_t c = 0; c < 3; c++) {
            samples_u16(s, PLANE_SUB_ALBEDO, k * 3 + c)[i] =
                (uint16_t)lrintf(p->albedo[c] * 65535.0f);
        }
    }
    if (!plan->light_planes) return;
    samples_light_irradiance(s, 0)[i] = p->irradiance;
    samples_light_visibility(s, 0, 0)[i] = (uint8_t)(p->visibility & 255u);
    samples_light_visibility(s, 0, 1)[i] = (uint8_t)(p->visibility >> 8);
}

static void put_pixel(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t i,
                      const void *ctx)
{
    (void)ctx;
    const struct synthetic_pixel p = synthetic_pixel(plan, x, y);
    synthetic_put(s, plan, i, &p);
}

struct samples *synthetic_tile(const struct plan *plan, uint32_t tile)
{
    return picture_tile(plan, tile, put_pixel, NULL);
}

struct samples *synthetic_tile_of(const struct plan *plan, uint32_t tile, const void *ctx)
{
    (void)ctx;
    return synthetic_tile(plan, tile);
}
