#pragma once
/* shadow_kernels' shear_receivers: filter widths and walks from wedges (filters.md section 2,
 * "Widths"). */
#include <math.h>

#include "server/reconstruct/receiver_lanes.h"
#include "server/reconstruct/wedge.h"

#define WEDGE_LANES        16
#define WEDGE_FLOOR_PX     0.25f /* slopes are at least this many pixels over L */
#define WEDGE_RANGE_LEAST  1e-6f
#define WEDGE_FALLOFF_MOST 1e30f
#define WEDGE_SIGMAS       2.5f /* that a walk goes: 3 give the same errors within 1 % */

struct wedge_chunk {
    float point[3][WEDGE_LANES], normal[3][WEDGE_LANES];
    float pixel[WEDGE_LANES], most[WEDGE_LANES], least[WEDGE_LANES];
    float eta[WEDGE_LANES], spread[WEDGE_LANES], wide[WEDGE_LANES];
    float step[2][2][WEDGE_LANES], falloff[2][WEDGE_LANES];
    int32_t reach[2][WEDGE_LANES], row[2][WEDGE_LANES];
};

/* Half a tap in half-sides of the light: how much farther than the light taps still reach. */
static inline float wedge_half_tap(float major, float eta, float half)
{
    const float delta = 0.5f * eta / half / (major > 1e-30f ? major : 1e-30f);
    return delta < 2.0f ? delta : 2.0f;
}

static inline void wedge_load(uint32_t i, float most, float least, const struct shadow_source *s,
                              const struct shadow_target *t, struct wedge_chunk *c)
{
    for (int k = 0; k < 3; k++) {
        c->point[k][i] = s->point[k];
        c->normal[k][i] = s->normal[k];
    }
    c->pixel[i] = receiver_pixel(t);
    c->most[i] = most;
    c->least[i] = least;
}

static inline void wedge_range(float longer_half, struct wedge_chunk *c)
{
    for (int i = 0; i < WEDGE_LANES; i++) {
        const float top = longer_half / (WEDGE_FLOOR_PX * c->pixel[i]);
        const float upper = c->most[i] < top ? c->most[i] : top;
        const float lower = c->least[i] < upper ? c->least[i] : upper, eta = 0.5f * (upper + lower);
        const float range = upper - lower > WEDGE_RANGE_LEAST ? upper - lower : WEDGE_RANGE_LEAST;
        c->eta[i] = eta;
        c->spread[i] = 0.5f * (upper - lower);
        c->wide[i] = range > eta ? range : eta;
    }
}

/* The walk along an axis of which a tap, one pixel of the longer screen axis, is `major` times in a
 * scene unit. */
static inline void wedge_walk(const struct wedge_shear *shear, int axis, struct wedge_chunk *c)
{
    const struct receiver_light *light = shear->light;
    const float half = light->rectangle.half[axis], sigma_y = light->sigma_y[axis];
    const float scale = shear->scale, most_px = shear->width_most_px, rho_most = shear->rho_most;
    const struct receiver_stepper stepper = receiver_stepper_of(light, axis);
    for (int i = 0; i < WEDGE_LANES; i++) {
        float step_x, step_y;
        receiver_step(&stepper, c->point[0][i], c->point[1][i], c->point[2][i], c->normal[0][i],
                      c->normal[1][i], c->normal[2][i], &step_x, &step_y);
        const float cap = most_px * c->pixel[i];
        const float own = scale * sigma_y / c->wide[i], sigma = own < cap ? own : cap;
        const float x = fabsf(step_x), y = fabsf(step_y), major = x > y ? x : y;
        const float delta = wedge_half_tap(major, c->eta[i], half);
        const float falloff = 0.5f / sigma / sigma, reach = ceilf(WEDGE_SIGMAS * sigma * major);
        c->row[axis][i] = coverage_row(rho_most, c->eta[i] * sigma / half, delta);
        c->falloff[axis][i] = falloff < WEDGE_FALLOFF_MOST ? falloff : WEDGE_FALLOFF_MOST;
        c->reach[axis][i] = (int32_t)(reach < SHADOW_REACH_PX ? reach : SHADOW_REACH_PX);
        c->step[axis][0][i] = major > 0.0f ? step_x / major : 0.0f;
        c->step[axis][1][i] = major > 0.0f ? step_y / major : 0.0f;
    }
}

static inline void wedge_store(const struct wedge_chunk *c, uint32_t i, struct shadow_source *s,
                               struct shadow_target *t)
{
    s->eta = c->eta[i];
    s->spread = c->spread[i];
    for (int axis = 0; axis < 2; axis++) {
        t->weights[axis] = c->row[axis][i];
        t->walk[axis] = (struct shadow_walk){
            {c->step[axis][0][i], c->step[axis][1][i]}, c->falloff[axis][i], c->reach[axis][i]};
    }
}

static void kernel_shear_receivers(const struct wedge_shear *shear, const uint32_t *pixels,
                                   uint32_t count, const float *most, const float *least,
                                   struct shadow_source *sources, struct shadow_target *targets)
{
    const float *half = shear->light->rectangle.half;
    struct wedge_chunk c;
    for (uint32_t first = 0; first < count; first += WEDGE_LANES) {
        const uint32_t left = count - first, n = left < WEDGE_LANES ? left : WEDGE_LANES;
        for (uint32_t i = 0; i < WEDGE_LANES; i++) { /* lanes past the end repeat the last pixel */
            const uint32_t pixel = pixels[first + (i < n ? i : n - 1)];
            wedge_load(i, most[pixel], least[pixel], &sources[pixel], &targets[pixel], &c);
        }
        wedge_range(half[0] > half[1] ? half[0] : half[1], &c);
        wedge_walk(shear, 0, &c);
        wedge_walk(shear, 1, &c);
        for (uint32_t i = 0; i < n; i++)
            wedge_store(&c, i, &sources[pixels[first + i]], &targets[pixels[first + i]]);
    }
}
