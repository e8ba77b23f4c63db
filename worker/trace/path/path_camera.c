/* Begins paths at points of the pixel and of the lens. */
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/shade/direction.h"
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
    p->part[i] = PATH_PART_NONE;
    p->from_object[i] = 0;
    p->colored[i] = 0;
    p->pdf[i] = 0.0f;
    p->promise[i] = 1.0f;
    p->rays.ray.time[i] = SHUTTER_MIDDLE_TIME;
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

static void place_on_lens(const struct path_context *c, const struct path_packet *p, float *s,
                          float *t)
{
    const struct plan_camera *camera = &c->plan->camera;
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES];
    c->kernels->path_pairs(p, PATH_LENS, u, v);
    for (int i = 0; i < LANES; i++) {
        if (camera->blade_count > 0)
            on_polygon(camera, u[i], v[i], &s[i], &t[i]);
        else
            on_disc(u[i], v[i], &s[i], &t[i]);
    }
}

static void bend_through_lens(const struct path_context *c, struct path_packet *p)
{
    _Alignas(LANES_ALIGN) float s[LANES], t[LANES];
    place_on_lens(c, p, s, t);
    c->kernels->lens_rays(&c->plan->camera, s, t, &p->rays.ray);
}

/* Sets lane i's ray through (x, y), and through (s, t) of the lens, as the camera is at its time.
 */
static void aim_lane(const struct plan *plan, int i, float x, float y, float s, float t,
                     struct RTCRay16 *r)
{
    struct plan_camera c;
    float o[3], d[3];
    plan_camera_at(plan, r->time[i], &c);
    plan_camera_ray_of(plan, &c, x, y, o, d);
    if (c.aperture_radius > 0.0f) {
        const float reach =
            c.focus_distance / (d[0] * c.forward[0] + d[1] * c.forward[1] + d[2] * c.forward[2]);
        for (int k = 0; k < 3; k++) {
            const float off = c.aperture_radius * (s * c.right[k] + t * c.up[k]);
            o[k] += off;
            d[k] = reach * d[k] - off;
        }
        direction_normalize(d[0], d[1], d[2], d);
    }
    r->org_x[i] = o[0], r->org_y[i] = o[1], r->org_z[i] = o[2];
    r->dir_x[i] = d[0], r->dir_y[i] = d[1], r->dir_z[i] = d[2];
    r->tnear[i] = 0.0f;
    r->tfar[i] = INFINITY;
}

/* Gives paths their times and aims them. */
static void aim_in_time(const struct path_context *c, const float *x, const float *y,
                        struct path_packet *p)
{
    _Alignas(LANES_ALIGN) float unused[LANES], s[LANES] = {0}, t[LANES] = {0};
    c->kernels->path_pairs(p, PATH_TIME, p->rays.ray.time, unused);
    if (c->plan->camera.aperture_radius > 0.0f) place_on_lens(c, p, s, t);
    for (int i = 0; i < LANES; i++) aim_lane(c->plan, i, x[i], y[i], s[i], t[i], &p->rays.ray);
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
    if (plan_has_shutter(c->plan)) {
        aim_in_time(c, x, y, p);
        return;
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
