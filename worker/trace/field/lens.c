#include "worker/trace/field/lens.h"

#include <math.h>

#include "proto/lens_slope.h"
#include "proto/pattern_path.h"
#include "worker/trace/field/lens_surface.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/path/path_kernels.h"

#define HALF_MAX 65504.0f

void lens_scratch_init(struct lens_scratch *s, const struct plan *plan)
{
    lens_pattern_init(&s->pattern, plan);
}

/* Points as lens_pattern_at has them, for next to nothing each. */
static void place_lines(const struct block *b, struct lens_scratch *s)
{
    const struct lens_aperture *a = &s->pattern.aperture;
    for (int i = 0; i < LANES; i++) {
        float across;
        lens_pattern_jitters(&s->pattern, b->x_px[i], b->y_px[i], 1, &s->along[i], &across);
        for (uint32_t k = 0; k < s->pattern.l; k++) {
            s->height[k][i] = lens_aperture_height(a, pattern_axis(across, s->pattern.l, k));
            lens_aperture_chord(a, s->height[k][i], &s->left[k][i], &s->right[k][i]);
        }
    }
}

static void lens_init(const struct path_context *c, const struct block *b, struct lens_scratch *s)
{
    const struct pattern *p = &c->plan->pattern;
    for (int i = 0; i < LANES; i++) {
        s->keys[i] = path_key(p->seed, p->frame, b->x_px[i], b->y_px[i]);
        s->seen[i] = 0.0f;
    }
    place_lines(b, s);
}

/* Rays of the packet's paths, from their points of the lens through their points of the pixel. */
static void aim(const struct path_context *c, const struct block *b, const struct lens_scratch *s,
                struct path_packet *p)
{
    _Alignas(LANES_ALIGN) float x[LANES] = {0}, y[LANES] = {0};
    _Alignas(LANES_ALIGN) float right_of[LANES] = {0}, above[LANES] = {0};
    _Alignas(LANES_ALIGN) float across[LANES], down[LANES];
    const struct plan *plan = c->plan;
    const uint32_t l = plan->lens_strata_per_axis;
    c->kernels->path_pairs(p, PATH_PIXEL, across, down);
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t lane = p->slot[i] % LANES, sample = p->sample[i];
        const float left = s->left[sample / l][lane], right = s->right[sample / l][lane];
        x[i] = (float)b->x_px[lane] + path_pixel_offset(plan, across[i]);
        y[i] = (float)b->y_px[lane] + path_pixel_offset(plan, down[i]);
        right_of[i] = left + (right - left) * pattern_axis(s->along[lane], l, sample % l);
        above[i] = -s->height[sample / l][lane]; /* the pattern's heights grow downwards */
    }
    c->queries->kernels->camera_rays(plan, x, y, &p->rays.ray);
    c->kernels->lens_rays(&plan->camera, right_of, above, &p->rays.ray);
}

static void begin(const struct path_context *c, const struct block *b, uint32_t first,
                  uint32_t count, const struct lens_scratch *s, struct path_pool *pool)
{
    pool->count = 0;
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t lane = 0; lane < LANES; lane++)
            if (b->kept.on[lane]) path_begin(s->keys[lane], first + k, k * LANES + lane, pool);
    for (uint32_t k = 0; k < path_pool_packets(pool); k++) aim(c, b, s, &pool->packets[k]);
    c->counters->value[COUNTER_LENS_SAMPLES] += pool->count;
}

void lens_begin(const struct path_context *c, const struct block *b, uint32_t sample,
                struct lens_scratch *s, struct path_pool *pool)
{
    lens_init(c, b, s);
    begin(c, b, sample, 1, s, pool);
}

/* Samples that are not finite count as black. */
static void store_radiance(const struct path_context *c, const struct block *b,
                           const struct path_radiance *h, size_t first, uint32_t sample,
                           struct samples *samples)
{
    const struct path_rgb *e = &h->emission, *d = &h->direct, *n = &h->indirect;
    const float most = LENS_RADIANCE_MAX;
    struct lanes3 sum;
    int32_t finite_count = 0;
    for (size_t i = 0; i < LANES; i++) {
        const size_t k = first + i;
        const float x = e->r[k] + d->r[k] + n->r[k], y = e->g[k] + d->g[k] + n->g[k];
        const float z = e->b[k] + d->b[k] + n->b[k];
        const int32_t finite = (x < INFINITY) & (y < INFINITY) & (z < INFINITY);
        const float red = x < most ? x : most, green = y < most ? y : most;
        const float blue = z < most ? z : most;
        sum.x[i] = finite ? red : 0.0f;
        sum.y[i] = finite ? green : 0.0f;
        sum.z[i] = finite ? blue : 0.0f;
        finite_count += finite;
    }
    c->counters->value[COUNTER_REJECTED_NOT_FINITE] += (uint64_t)(LANES - finite_count);
    const float *planes[3] = {sum.x, sum.y, sum.z};
    for (uint32_t k = 0; k < 3; k++)
        block_store_f32(b, planes[k], samples_f32(samples, PLANE_LENS_RADIANCE, sample * 3 + k));
}

/* Stores how far a sample's point moves in the image from the lens's centre to its edge. Points
 * nearly at the lens have the largest number. */
static void store_slope(const struct plan *plan, const struct block *b, const float depth[LANES],
                        uint32_t sample, struct samples *samples)
{
    _Alignas(LANES_ALIGN) float slope[LANES];
    const struct lens_sloper sloper = lens_sloper_of(plan);
    for (int i = 0; i < LANES; i++) {
        const float own = lens_slope(sloper, depth[i]);
        const float bounded = own > -HALF_MAX ? own : -HALF_MAX;
        slope[i] = bounded < HALF_MAX ? bounded : HALF_MAX;
    }
    block_store_half(b, slope, 1.0f, samples_u16(samples, PLANE_LENS_SLOPE, sample));
}

static void store_batch(const struct path_context *c, const struct block *b, uint32_t first,
                        uint32_t count, struct path_radiance *h, struct lens_scratch *s,
                        struct samples *samples)
{
    for (uint32_t k = 0; k < count; k++) {
        const size_t slot = (size_t)k * LANES;
        _Alignas(LANES_ALIGN) float depth[LANES];
        for (size_t i = 0; i < LANES; i++) {
            const float z = h->ahead[slot + i];
            depth[i] = z > 0.0f ? z : INFINITY; /* lanes that are not the tile's have none */
            s->seen[i] += h->coverage[slot + i];
        }
        lens_surface_store(c, b, slot, first + k, h, samples);
        store_radiance(c, b, h, slot, first + k, samples);
        store_slope(c->plan, b, depth, first + k, samples);
    }
}

void lens_trace(const struct path_context *c, const struct block *block, struct lens_scratch *s,
                struct path_scratch *paths, struct path_sums *sums, struct samples *samples)
{
    const uint32_t l = c->plan->lens_strata_per_axis, count = l * l;
    const bool summed = plan_lens_has_paths(c->plan);
    lens_init(c, block, s);
    if (summed) path_sums_init_lens(sums, l, samples->layout.planes);
    for (uint32_t done = 0; done < count;) {
        const uint32_t left = count - done, n = left < PATH_SAMPLES ? left : PATH_SAMPLES;
        if (done > 0 && !path_goes_on(c)) return;
        begin(c, block, done, n, s, &paths->pools[0]);
        path_trace_camera(c, paths);
        if (summed) path_sums_add(sums, &paths->radiance, n, c->demodulate, c->counters);
        store_batch(c, block, done, n, &paths->radiance, s, samples);
        done += n;
    }
    if (summed) path_sums_store(sums, block, samples);
    block_store_half(block, s->seen, 1.0f / (float)count,
                     samples_u16(samples, PLANE_LENS_COVERAGE, 0));
}
