#pragma once
/* The shear_receivers of shadow_kernels: filter widths and walks from wedges
 * (docs/reconstruction.md, Shadow widths). */
#include <math.h>

#include "server/reconstruct/shadow/receiver_lanes.h"
#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/shadow/wedge.h"
#include "server/reconstruct/simd/inline.h"

#define WEDGE_FLOOR_PX    0.25f /* slopes are at least this many pixels over L */
#define WEDGE_RANGE_MIN   1e-6f
#define WEDGE_FALLOFF_MAX 1e30f
#define WEDGE_SIGMA_MIN   7.07e-16f /* (2 WEDGE_FALLOFF_MAX)^-1/2 */
#define WEDGE_MAJOR_MIN   1e-30f
#define WEDGE_SIGMAS                                                                               \
    2.0f /* of a walk's reach; 2.5 has the same error, with walks a quarter longer */

/* What is read of a pixel. */
enum wedge_read {
    WEDGE_POINT = 0,
    WEDGE_NORMAL = 3,
    WEDGE_PLANE_MIN = 6,
    WEDGE_MAX,
    WEDGE_MIN,
    WEDGE_READ,
};

/* What is written, axis 0 before axis 1, integers last. */
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

/* What both axes share. */
enum wedge_shared {
    WEDGE_AIM = 0, /* struct receiver_aim */
    WEDGE_PIXEL = 7,
    WEDGE_INVERSE_PIXEL,
    WEDGE_WIDE,
    WEDGE_INVERSE_WIDE,
    WEDGE_SHARED,
};

struct wedge_chunk {
    _Alignas(64) float in[WEDGE_READ][SIMD_LANES], out[WEDGE_WRITTEN][SIMD_LANES];
    float shared[WEDGE_SHARED][SIMD_LANES], sigma[2][SIMD_LANES];
    float rho[2][SIMD_LANES], delta[2][SIMD_LANES];
    int32_t whole[WEDGE_WHOLE][SIMD_LANES];
};

/* Computes eta, the middle of the wedge, and wide = max(its range, eta), by which widths shrink. */
static inline void wedge_range(float longer_half, struct wedge_chunk *c)
{
    const float *least = c->in[WEDGE_MIN], *most = c->in[WEDGE_MAX];
    for (int i = 0; i < SIMD_LANES; i++) {
        const float pixel = receiver_size(c->in[WEDGE_PLANE_MIN][i]), inverse = 1.0f / pixel;
        const float top = longer_half / WEDGE_FLOOR_PX * inverse;
        const float upper = most[i] < top ? most[i] : top;
        const float lower = least[i] < upper ? least[i] : upper, eta = 0.5f * (upper + lower);
        const float range = upper - lower > WEDGE_RANGE_MIN ? upper - lower : WEDGE_RANGE_MIN;
        const float wide = range > eta ? range : eta;
        c->out[WEDGE_ETA][i] = eta;
        c->out[WEDGE_SPREAD][i] = 0.5f * (upper - lower);
        c->shared[WEDGE_PIXEL][i] = pixel;
        c->shared[WEDGE_INVERSE_PIXEL][i] = inverse;
        c->shared[WEDGE_WIDE][i] = wide;
        c->shared[WEDGE_INVERSE_WIDE][i] = 1.0f / wide;
    }
}

/* Constants of widths and walks, with inverses of widths and of the table's rho. */
struct wedge_rule {
    float per_half[2], own[2], per_own[2]; /* own: m mu sigma_y, sigma where wide is 1 */
    float longer_half, most_px, per_max, per_rho;
    struct receiver_stepper stepper[2];
};

static inline struct wedge_rule wedge_rule_of(const struct wedge_shear *shear)
{
    const struct receiver_light *light = shear->light;
    const float *half = light->rectangle.half;
    struct wedge_rule r = {.longer_half = half[0] > half[1] ? half[0] : half[1],
                           .most_px = shear->width_max_px,
                           .per_max = 1.0f / shear->width_max_px,
                           .per_rho = 1.0f / shear->rho_max};
    for (int axis = 0; axis < 2; axis++) {
        r.per_half[axis] = 1.0f / half[axis];
        r.own[axis] = shear->scale * light->sigma_y[axis];
        r.per_own[axis] = 1.0f / r.own[axis];
        r.stepper[axis] = receiver_stepper_of(light, axis);
    }
    return r;
}

static inline void wedge_aim(const struct receiver_stepper *stepper, struct wedge_chunk *c)
{
    const struct receiver_stepper s = *stepper;
    const float(*in)[SIMD_LANES] = (const float(*)[SIMD_LANES])c->in;
    float(*out)[SIMD_LANES] = c->shared + WEDGE_AIM;
    for (int i = 0; i < SIMD_LANES; i++) {
        const struct receiver_aim aim =
            receiver_aim(&s, in[0][i], in[1][i], in[2][i], in[3][i], in[4][i], in[5][i]);
        out[0][i] = aim.x, out[1][i] = aim.y, out[2][i] = aim.z;
        out[3][i] = aim.inverse_up, out[4][i] = aim.inverse_depth;
        out[5][i] = aim.across, out[6][i] = aim.above;
    }
}

/* Computes the walk along an axis, whose width in scene units is
 *
 *     sigma = min(wedge_scale sigma_y / wide, width_max_px px).
 *
 * A scene unit has `major` taps, each one pixel of the longer screen axis. */
SIMD_INLINE void wedge_walk(const struct wedge_rule *rule, int axis, struct wedge_chunk *c)
{
    const float per_half = rule->per_half[axis];
    const float all_own = rule->own[axis], per_own = rule->per_own[axis];
    const float most_px = rule->most_px, per_max = rule->per_max;
    const struct receiver_stepper stepper = rule->stepper[axis];
    const float(*n)[SIMD_LANES] = (const float(*)[SIMD_LANES])c->in + WEDGE_NORMAL;
    const float(*s)[SIMD_LANES] = (const float(*)[SIMD_LANES])c->shared;
    for (int i = 0; i < SIMD_LANES; i++) {
        const struct receiver_aim aim = {s[0][i], s[1][i], s[2][i], s[3][i],
                                         s[4][i], s[5][i], s[6][i]};
        float step_x, step_y;
        receiver_step(&stepper, &aim, n[0][i], n[1][i], n[2][i], &step_x, &step_y);
        const float cap = most_px * s[WEDGE_PIXEL][i], own = all_own * s[WEDGE_INVERSE_WIDE][i];
        const float sigma = own < cap ? own : cap, eta = c->out[WEDGE_ETA][i];
        const float per_sigma =
            own < cap ? per_own * s[WEDGE_WIDE][i] : per_max * s[WEDGE_INVERSE_PIXEL][i];
        const float x = fabsf(step_x), y = fabsf(step_y), major = x > y ? x : y;
        const float per_major = 1.0f / (major > WEDGE_MAJOR_MIN ? major : WEDGE_MAJOR_MIN);
        const float falloff = 0.5f * per_sigma * per_sigma;
        const float reach = ceilf(WEDGE_SIGMAS * sigma * major);
        /* half a tap in half-sides of the light: how far beyond it taps still reach */
        const float delta = 0.5f * eta * per_half * per_major;
        c->sigma[axis][i] = sigma;
        c->rho[axis][i] = eta * sigma * per_half;
        c->delta[axis][i] = delta;
        c->out[WEDGE_FALLOFF + axis][i] = falloff < WEDGE_FALLOFF_MAX ? falloff : WEDGE_FALLOFF_MAX;
        c->whole[WEDGE_REACH + axis][i] =
            (int32_t)(reach < SHADOW_REACH_PX ? reach : SHADOW_REACH_PX);
        /* exactly 1 or -1 along the longer axis */
        c->out[WEDGE_STEP_X + axis][i] =
            major > 0.0f && x == major ? copysignf(1.0f, step_x) : step_x * per_major;
        c->out[WEDGE_STEP_Y + axis][i] =
            major > 0.0f && y == major ? copysignf(1.0f, step_y) : step_y * per_major;
    }
}

/* Computes rows of weights. It is apart from the walks so as not to wait for their roots. */
static inline void wedge_rows(float per_rho, struct wedge_chunk *c)
{
    for (int axis = 0; axis < 2; axis++)
        for (int i = 0; i < SIMD_LANES; i++)
            c->whole[WEDGE_ROW + axis][i] =
                coverage_row(per_rho, c->rho[axis][i], c->delta[axis][i]);
}

/* Computes filter widths in pixels, never 0 where there is a walk. Roots are taken one by one,
 * because products may overflow. */
static inline void wedge_widths(struct wedge_chunk *c)
{
    const float *a = c->out[WEDGE_FALLOFF], *b = c->out[WEDGE_FALLOFF + 1];
    for (int i = 0; i < SIMD_LANES; i++) {
        const float u = c->sigma[0][i] > WEDGE_SIGMA_MIN ? c->sigma[0][i] : WEDGE_SIGMA_MIN;
        const float v = c->sigma[1][i] > WEDGE_SIGMA_MIN ? c->sigma[1][i] : WEDGE_SIGMA_MIN;
        const float width = sqrtf(u) * sqrtf(v) * c->shared[WEDGE_INVERSE_PIXEL][i];
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
    const void *const read[WEDGE_READ] = {out->point[0],  out->point[1],  out->point[2],
                                          out->normal[0], out->normal[1], out->normal[2],
                                          out->plane_min, most,           least};
    void *const written[WEDGE_WRITTEN] = {out->eta,   out->spread, a->step[0],
                                          b->step[0], a->step[1],  b->step[1],
                                          a->falloff, b->falloff,  out->width_px};
    void *const whole[WEDGE_WHOLE] = {a->reach, b->reach, out->weights[0], out->weights[1]};
    struct wedge_chunk c;
    _Alignas(64) int32_t to[SIMD_LANES];
    for (uint32_t first = 0; first < count; first += SIMD_LANES) {
        simd_list(pixels + first, count - first, to);
        simd_take(read, WEDGE_READ, to, c.in);
        wedge_range(rule.longer_half, &c);
        wedge_aim(&rule.stepper[0], &c);
        wedge_walk(&rule, 0, &c);
        wedge_walk(&rule, 1, &c);
        wedge_rows(rule.per_rho, &c);
        wedge_widths(&c);
        simd_put(written, WEDGE_WRITTEN, to, c.out);
        simd_put(whole, WEDGE_WHOLE, to, c.whole);
    }
}
