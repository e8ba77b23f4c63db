#include "tests/unit/server/reconstruct/lighting/lens_wall.h"

#include "proto/half.h"
#include "proto/lens_pattern.h"
#include "proto/octahedron.h"
#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "proto/shared_exponent.h"
#include "tests/unit/server/reconstruct/film_picture.h"

float wall_edge = 0.5f * SIDE;
bool wall_noise;

void wall_plan(struct plan *plan, uint32_t filter)
{
    *plan = (struct plan){
        .width_px = SIDE,
        .height_px = SIDE,
        .tile_px = TILE,
        .pattern = {3, 1},
        .camera = {.type = CAMERA_PERSPECTIVE,
                   .right = {1, 0, 0},
                   .up = {0, 1, 0},
                   .forward = {0, 0, -1},
                   .half_width = 0.5f,
                   .half_height = 0.5f,
                   .aperture_radius = 0.18f,
                   .focus_distance = 4},
        .light_count = 1,
        .lights = {{.type = LIGHT_POINT, .color = {3, 2, 1}, .power = 1, .strata_per_axis = 1}},
        .planes = PLANES_LENS | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL),
        .light_planes = 1u << LIGHT_PLANE_IRRADIANCE,
        .lens_strata_per_axis = L,
        .lens_filter = filter,
        .lens_relight = LENS_RELIGHT_DIFFUSE,
        .radiance_scale = 4,
        .length_unit = 1,
        .mu = 1,
    };
}

float wall_slope(const struct plan *plan, float z)
{
    const float scale = plan->camera.aperture_radius * (float)SIDE;
    return half_to_float(half_from_float(scale * (1.0f / z - 1.0f / plan->camera.focus_distance)));
}

/* What a pinhole sees. */
static float depth_at(float x)
{
    return x < wall_edge ? NEAR_Z : FAR_Z;
}

float wall_irradiance(float x, float y)
{
    return 1.0f + 0.01f * x + 0.02f * y;
}

static void put_sample(const struct plan *plan, const struct lens_pattern *pattern,
                       struct samples *s, int32_t x, int32_t y, uint32_t k, size_t at)
{
    static const float normal[3] = {0, 0, 1}, albedo[3] = {0.5f, 0.5f, 0.25f};
    const float found =
        wall_noise ? 40.0f * (float)((7 * x + 13 * y + 5 * (int32_t)k) % 11) : 256.0f;
    const float own[3] = {found, found, found};
    float u[2], p[2];
    lens_pattern_at(pattern, x, y, k / L, k % L, u);
    path_pair(path_key(plan->pattern.seed, plan->pattern.frame, x, y), k, PATH_PIXEL, &p[0], &p[1]);
    const float qx = (float)x + p[0] + wall_slope(plan, NEAR_Z) * u[0];
    const float z = qx < wall_edge ? NEAR_Z : FAR_Z; /* the near wall hides what is behind it */
    samples_u16(s, PLANE_LENS_COVERAGE, 0)[at] = half_from_float(1.0f);
    samples_u16(s, PLANE_LENS_SLOPE, k)[at] = half_from_float(wall_slope(plan, z));
    samples_u16(s, PLANE_LENS_DEPTH, k)[at] = half_from_float(z);
    samples_u16(s, PLANE_LENS_NORMAL, k)[at] = octahedron_pack8(normal);
    samples_u32(s, PLANE_LENS_ALBEDO, k)[at] = shared_exponent_pack(albedo, SHARED_EXPONENT_9);
    samples_u32(s, PLANE_LENS_OWN_LIGHT, k)[at] = shared_exponent_pack(own, SHARED_EXPONENT_8);
    samples_f32(s, PLANE_LENS_RADIANCE, k * 3 + 2)[at] = 0.125f; /* shines by itself */
}

static void put_pixel(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t at,
                      const void *ctx)
{
    static const float normal[3] = {0, 0, 1};
    float from[3], d[3];
    plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, from, d);
    samples_f32(s, PLANE_DEPTH, 0)[at] = depth_at((float)x + 0.5f) / -d[2];
    samples_u32(s, PLANE_NORMAL, 0)[at] = octahedron_pack16(normal);
    samples_light_irradiance(s, 0)[at] = wall_irradiance((float)x + 0.5f, (float)y + 0.5f);
    for (uint32_t k = 0; k < N; k++) put_sample(plan, ctx, s, x, y, k, at);
}

void wall_land(const struct plan *plan, struct film *film)
{
    struct lens_pattern pattern;
    lens_pattern_init(&pattern, plan);
    picture_land_pixels(plan, film, put_pixel, &pattern);
}
