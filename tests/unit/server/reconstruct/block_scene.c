#include "tests/unit/server/reconstruct/block_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct shade {
    float depth, normal[3], albedo, light;
    uint32_t id;
};

const struct world plain = {.edge_x = -1e6f,
                            .near_depth = 2.0f,
                            .far_depth = 5.0f,
                            .near_light = PI,
                            .far_light = PI,
                            .near_albedo = 0.5f,
                            .far_albedo = 0.5f,
                            .near_id = 1,
                            .far_id = 2};

/* What the ray through (px, py) meets; depth along the unit ray. */
static struct shade look(const struct plan *plan, const struct world *w, float px, float py)
{
    struct shade s = {0};
    float origin[3], d[3];
    plan_camera_ray(plan, px, py, origin, d);
    const float left = w->edge_x + w->slant * py - px;
    if (left > 0 && (w->slat_px == 0 || left < w->slat_px)) {
        const float n[3] = {sinf(w->normal_turn), 0, cosf(w->normal_turn)};
        memcpy(s.normal, n, sizeof n);
        s = (struct shade){.depth = w->near_depth / -d[2],
                           .normal = {n[0], n[1], n[2]},
                           .albedo = w->near_albedo,
                           .light = w->near_light,
                           .id = w->near_id};
    } else if (!w->far_missing) {
        const float n[3] = {0, sinf(w->tilt), cosf(w->tilt)};
        float facing = -(d[1] * n[1] + d[2] * n[2]);
        s = (struct shade){.depth = w->far_depth * n[2] / facing,
                           .normal = {n[0], n[1], n[2]},
                           .albedo = w->far_albedo,
                           .light = w->far_light,
                           .id = w->far_id};
    }
    return s;
}

static void put_pixel(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t i,
                      const void *w)
{
    struct shade centre = look(plan, w, (float)x + 0.5f, (float)y + 0.5f);
    bool hit = centre.depth > 0.0f;
    samples_f32(s, PLANE_DEPTH, 0)[i] = centre.depth;
    samples_u32(s, PLANE_ID, 0)[i] = centre.id;
    samples_u32(s, PLANE_NORMAL, 0)[i] = hit ? octahedron_pack16(centre.normal) : 0;
    samples_light_irradiance(s, 0)[i] = centre.light;
    for (uint32_t c = 0; c < 3; c++) {
        samples_u16(s, PLANE_ALBEDO, c)[i] = (uint16_t)lrintf(centre.albedo * 65535.0f);
    }
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        float at[2];
        pattern_pixel(&plan->pattern, x, y, k, plan->sub_samples, at);
        struct shade sub = look(plan, w, (float)x + at[0], (float)y + at[1]);
        bool sub_hit = sub.depth > 0.0f;
        float reference = hit ? centre.depth : plan->length_unit;
        samples_u16(s, PLANE_SUB_DEPTH, k)[i] =
            half_from_float(sub_hit ? sub.depth / reference - 1.0f : SUB_DEPTH_MISS);
        samples_u16(s, PLANE_SUB_ID, k)[i] = synthetic_sub_id(sub.id);
        samples_u16(s, PLANE_SUB_NORMAL, k)[i] = sub_hit ? octahedron_pack8(sub.normal) : 0;
        for (uint32_t c = 0; c < 3; c++) {
            samples_u16(s, PLANE_SUB_ALBEDO, k * 3 + c)[i] =
                (uint16_t)lrintf(sub.albedo * 65535.0f);
        }
    }
}

struct samples *world_tile(const struct plan *plan, const struct world *w, uint32_t tile)
{
    return picture_tile(plan, tile, put_pixel, w);
}

static double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

struct image *render(const struct plan *plan, const struct world *w, int32_t block_px,
                     int32_t more_halo_px, struct block_statistics *sum, double *seconds)
{
    struct film *film = picture_film(plan, block_px, more_halo_px);
    struct image *image;
    assert_int_equal(image_create(ALL_LAYERS, plan->width_px, plan->height_px, &image), 0);
    if (w)
        picture_land_pixels(plan, film, put_pixel, w);
    else
        picture_land(plan, film, synthetic_tile_of, NULL);
    const double start = cpu_s();
    if (sum) *sum = (struct block_statistics){0};
    picture_draw(plan, film, image, sum);
    if (seconds) *seconds = cpu_s() - start;
    assert_true(film_complete(film));
    film_destroy(&film);
    return image;
}
