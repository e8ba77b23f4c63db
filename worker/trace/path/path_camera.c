/* Begins paths at points of the pixel and of the lens. */
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/shade/lambert.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/path/path_kernels.h"

void path_pool_init(struct path_pool *pool)
{
    memset(pool, 0, sizeof *pool);
    for (int i = 0; i < PATH_SAMPLES; i++) queries_init_rays(&pool->packets[i].rays);
}

void path_begin(uint32_t key, uint32_t sample, uint32_t slot, struct path_pool *pool)
{
    uint32_t i;
    struct path_packet *p = path_pool_add(pool, &i);
    p->key[i] = key;
    p->sample[i] = sample;
    p->slot[i] = slot;
    p->colored[i] = 0;
    p->pdf[i] = 0.0f;
    p->throughput.x[i] = p->throughput.y[i] = p->throughput.z[i] = 1.0f;
}

/* Maps (u, v) to the unit disc by Shirley and Chiu's concentric map, as for Lambert directions. */
static void on_disc(float u, float v, float *s, float *t)
{
    float height;
    lambert_direction(u, v, s, t, &height);
}

/* Maps (u, v) to the regular polygon: to one of the triangles from its centre, uniformly within. */
static void on_polygon(const struct plan_camera *camera, float u, float v, float *s, float *t)
{
    const float blades = (float)camera->blade_count;
    float blade = floorf(u * blades), rest = u * blades - blade,
          step = 2.0f * ELEMENTARY_PI / blades;
    float from = camera->blade_rotation_rad + blade * step, radius = sqrtf(v);
    float a = radius * (1.0f - rest), b = radius * rest;
    *s = a * elementary_cos(from) + b * elementary_cos(from + step);
    *t = a * elementary_sin(from) + b * elementary_sin(from + step);
}

static void bend_through_lens(const struct path_context *c, struct path_packet *p)
{
    const struct plan_camera *camera = &c->plan->camera;
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES], s[LANES], t[LANES];
    c->kernels->path_pairs(p, PATH_LENS, u, v);
    for (int i = 0; i < LANES; i++) {
        if (camera->blade_count > 0)
            on_polygon(camera, u[i], v[i], &s[i], &t[i]);
        else
            on_disc(u[i], v[i], &s[i], &t[i]);
    }
    c->kernels->lens_rays(camera, s, t, &p->rays.ray);
}

/* Maps u to [-1, 1] with a tent's density, by its inverse distribution function. */
static float on_tent(float u)
{
    return u < 0.5f ? sqrtf(2.0f * u) - 1.0f : 1.0f - sqrtf(2.0f - 2.0f * u);
}

float path_pixel_offset(const struct plan *plan, float u)
{
    return plan->paths.pixel_filter == PIXEL_FILTER_TENT ? 0.5f + on_tent(u) : u;
}

/* Aims the packet's paths at pixels of the block. */
static void aim(const struct path_context *c, const struct block *b, struct path_packet *p)
{
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES], x[LANES] = {0}, y[LANES] = {0};
    c->kernels->path_pairs(p, PATH_PIXEL, u, v);
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t lane = p->slot[i] % LANES;
        x[i] = (float)b->x_px[lane] + path_pixel_offset(c->plan, u[i]);
        y[i] = (float)b->y_px[lane] + path_pixel_offset(c->plan, v[i]);
    }
    c->queries->kernels->camera_rays(c->plan, x, y, &p->rays.ray);
    if (c->plan->camera.aperture_radius > 0.0f) bend_through_lens(c, p);
}

void path_camera(const struct path_context *c, const struct block *b, uint32_t first,
                 uint32_t count, struct path_pool *pool)
{
    const struct pattern *pattern = &c->plan->pattern;
    struct path_places places[LANES];
    pool->count = 0;
    for (uint32_t i = 0; i < LANES; i++)
        places[i] = path_edge_places_of(pattern->seed, pattern->frame, b->x_px[i], b->y_px[i],
                                        c->plan->paths.spp, c->edge_digits);
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t lane = 0; lane < LANES; lane++)
            if (b->kept.on[lane])
                path_begin(path_place_key(places[lane], first + k),
                           path_place_sample(places[lane], first + k), k * LANES + lane, pool);
    for (uint32_t k = 0; k < path_pool_packets(pool); k++) aim(c, b, &pool->packets[k]);
    c->counters->value[COUNTER_PATHS] += c->seen_only ? 0 : pool->count;
}
