#pragma once
/* shadow_kernels' shear_receivers: filter widths and walks from wedges (filters.md section 2,
 * "Widths"). */
#include <math.h>

#include "server/reconstruct/lanes_inline.h"
#include "server/reconstruct/receiver_lanes.h"
#include "server/reconstruct/shadow_lanes.h"
#include "server/reconstruct/wedge.h"

#define WEDGE_FLOOR_PX     0.25f /* slopes are at least this many pixels over L */
#define WEDGE_RANGE_LEAST  1e-6f
#define WEDGE_FALLOFF_MOST 1e30f
#define WEDGE_SIGMAS       2.5f /* that a walk goes: 3 give the same errors within 1 % */

/* What is read of a pixel, */
enum wedge_read {
    WEDGE_POINT = 0,
    WEDGE_NORMAL = 3,
    WEDGE_PLANE_LEAST = 6,
    WEDGE_MOST,
    WEDGE_LEAST,
    WEDGE_READ,
};

/* and written, axis 0 before axis 1; then what is whole. */
enum wedge_written {
    WEDGE_ETA = 0,
    WEDGE_SPREAD,
    WEDGE_STEP_X,
    WEDGE_STEP_Y = WEDGE_STEP_X + 2,
    WEDGE_FALLOFF = WEDGE_STEP_Y + 2,
    WEDGE_WIDTH = WEDGE_FALLOFF + 2,
    WEDGE_WRITTEN,
};
enum wedge_whole { WEDGE_REACH = 0, WEDGE_ROW = 2, WEDGE_WHOLE = 4 };

struct wedge_chunk {
    _Alignas(64) float in[WEDGE_READ][SHADOW_LANES], out[WEDGE_WRITTEN][SHADOW_LANES];
    float pixel[SHADOW_LANES], wide[SHADOW_LANES];
    int32_t whole[WEDGE_WHOLE][SHADOW_LANES];
};

/* Half a tap in half-sides of the light: how much farther than the light taps still reach. */
static inline float wedge_half_tap(float major, float eta, float half)
{
    const float delta = 0.5f * eta / half / (major > 1e-30f ? major : 1e-30f);
    return delta < 2.0f ? delta : 2.0f;
}

static inline void wedge_range(float longer_half, struct wedge_chunk *c)
{
    const float *least = c->in[WEDGE_LEAST], *most = c->in[WEDGE_MOST];
    for (int i = 0; i < SHADOW_LANES; i++) {
        const float pixel = receiver_size(c->in[WEDGE_PLANE_LEAST][i]);
        const float top = longer_half / (WEDGE_FLOOR_PX * pixel);
        const float upper = most[i] < top ? most[i] : top;
        const float lower = least[i] < upper ? least[i] : upper, eta = 0.5f * (upper + lower);
        const float range = upper - lower > WEDGE_RANGE_LEAST ? upper - lower : WEDGE_RANGE_LEAST;
        c->pixel[i] = pixel;
        c->out[WEDGE_ETA][i] = eta;
        c->out[WEDGE_SPREAD][i] = 0.5f * (upper - lower);
        c->wide[i] = range > eta ? range : eta;
    }
}

/* Constants of widths and walks. */
struct wedge_rule {
    float half[2], sigma_y[2], longer_half, scale, width_most_px, rho_most;
    struct receiver_stepper stepper[2];
};

static inline struct wedge_rule wedge_rule_of(const struct wedge_shear *shear)
{
    const struct receiver_light *light = shear->light;
    const float *half = light->rectangle.half, *sigma_y = light->sigma_y;
    return (struct wedge_rule){
        .half = {half[0], half[1]},
        .sigma_y = {sigma_y[0], sigma_y[1]},
        .longer_half = half[0] > half[1] ? half[0] : half[1],
        .scale = shear->scale,
        .width_most_px = shear->width_most_px,
        .rho_most = shear->rho_most,
        .stepper = {receiver_stepper_of(light, 0), receiver_stepper_of(light, 1)}};
}

/* The walk along an axis of which a tap, one pixel of the longer screen axis, is `major` times in a
 * scene unit. */
LANES_INLINE void wedge_walk(const struct wedge_rule *rule, int axis, struct wedge_chunk *c)
{
    const float half = rule->half[axis], sigma_y = rule->sigma_y[axis], scale = rule->scale;
    const float most_px = rule->width_most_px, rho_most = rule->rho_most;
    const struct receiver_stepper stepper = rule->stepper[axis];
    const float(*in)[SHADOW_LANES] = (const float(*)[SHADOW_LANES])c->in;
    for (int i = 0; i < SHADOW_LANES; i++) {
        float step_x, step_y;
        receiver_step(&stepper, in[0][i], in[1][i], in[2][i], in[3][i], in[4][i], in[5][i], &step_x,
                      &step_y);
        const float cap = most_px * c->pixel[i], eta = c->out[WEDGE_ETA][i];
        const float own = scale * sigma_y / c->wide[i], sigma = own < cap ? own : cap;
        const float x = fabsf(step_x), y = fabsf(step_y), major = x > y ? x : y;
        const float delta = wedge_half_tap(major, eta, half);
        const float falloff = 0.5f / sigma / sigma, reach = ceilf(WEDGE_SIGMAS * sigma * major);
        c->whole[WEDGE_ROW + axis][i] = coverage_row(rho_most, eta * sigma / half, delta);
        c->out[WEDGE_FALLOFF + axis][i] =
            falloff < WEDGE_FALLOFF_MOST ? falloff : WEDGE_FALLOFF_MOST;
        c->whole[WEDGE_REACH + axis][i] =
            (int32_t)(reach < SHADOW_REACH_PX ? reach : SHADOW_REACH_PX);
        c->out[WEDGE_STEP_X + axis][i] = major > 0.0f ? step_x / major : 0.0f;
        c->out[WEDGE_STEP_Y + axis][i] = major > 0.0f ? step_y / major : 0.0f;
    }
}

/* Filters' widths in pixels. sigma = (2 falloff)^-1/2, never 0; the roots are taken one by one,
 * since products may overflow. */
static inline void wedge_widths(struct wedge_chunk *c)
{
    const float *a = c->out[WEDGE_FALLOFF], *b = c->out[WEDGE_FALLOFF + 1];
    for (int i = 0; i < SHADOW_LANES; i++) {
        const float sigma = sqrtf(sqrtf(0.5f / a[i])) * sqrtf(sqrtf(0.5f / b[i]));
        const float width = sigma / c->pixel[i];
        const int32_t walks = (a[i] > 0.0f) & (b[i] > 0.0f);
        c->out[WEDGE_WIDTH][i] = walks ? width : 0.0f;
    }
}

static void kernel_shear_receivers(const struct wedge_shear *shear, const uint32_t *pixels,
                                   uint32_t count, const float *most, const float *least,
                                   const struct shadow_pixels *out)
{
    const struct wedge_rule rule = wedge_rule_of(shear);
    const struct shadow_walk *a = &out->walk[0], *b = &out->walk[1];
    const void *const read[WEDGE_READ] = {out->point[0],    out->point[1],  out->point[2],
                                          out->normal[0],   out->normal[1], out->normal[2],
                                          out->plane_least, most,           least};
    void *const written[WEDGE_WRITTEN] = {out->eta,   out->spread, a->step[0],
                                          b->step[0], a->step[1],  b->step[1],
                                          a->falloff, b->falloff,  out->width_px};
    void *const whole[WEDGE_WHOLE] = {a->reach, b->reach, out->weights[0], out->weights[1]};
    struct wedge_chunk c;
    _Alignas(64) int32_t to[SHADOW_LANES];
    for (uint32_t first = 0; first < count; first += SHADOW_LANES) {
        lanes_list(pixels + first, count - first, to);
        lanes_take(read, WEDGE_READ, to, c.in);
        wedge_range(rule.longer_half, &c);
        wedge_walk(&rule, 0, &c);
        wedge_walk(&rule, 1, &c);
        wedge_widths(&c);
        lanes_put(written, WEDGE_WRITTEN, to, c.out);
        lanes_put(whole, WEDGE_WHOLE, to, c.whole);
    }
}
