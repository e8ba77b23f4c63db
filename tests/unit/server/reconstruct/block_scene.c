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

static void put_pixel(struct samples *s, const struct plan *plan, const struct world *w, size_t i,
                      int32_t x, int32_t y)
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
    struct tile_grid grid;
    struct samples_layout layout;
    struct samples *s;
    tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px);
    struct rect r = tile_grid_rect(&grid, tile);
    assert_int_equal(samples_layout_init(&layout, plan, 0, rect_width(r), rect_height(r)), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    size_t i = 0;
    for (int32_t y = r.y0; y < r.y1; y++) {
        for (int32_t x = r.x0; x < r.x1; x++) put_pixel(s, plan, w, i++, x, y);
    }
    return s;
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
    struct film *film;
    struct image *image;
    struct tile_grid grid;
    struct block_statistics statistics;
    uint32_t block;
    tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px);
    assert_int_equal(
        film_create(plan, block_px, block_core_px(plan), block_halo_px(plan) + more_halo_px, &film),
        0);
    assert_int_equal(image_create(ALL_LAYERS, plan->width_px, plan->height_px, &image), 0);
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++) {
        struct samples *s = w ? world_tile(plan, w, t) : synthetic_tile(plan, t);
        assert_int_equal(film_land(film, t, 0, s), 0);
    }
    double start = cpu_s();
    if (sum) *sum = (struct block_statistics){0};
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_int_equal(
            block_reconstruct(plan, patch, film_block_rect(film, block), image, &statistics), 0);
        patch_destroy(&patch);
        film_block_done(film, block);
        if (!sum) continue;
        sum->sub_samples_unmatched += statistics.sub_samples_unmatched;
        sum->pixels_background += statistics.pixels_background;
    }
    if (seconds) *seconds = cpu_s() - start;
    assert_true(film_complete(film));
    film_destroy(&film);
    return image;
}

float at(const struct image *image, const char *channel, int32_t x, int32_t y)
{
    const struct plane *plane = image_plane(image, channel);
    assert_non_null(plane);
    return *plane_at(plane, x, y);
}
