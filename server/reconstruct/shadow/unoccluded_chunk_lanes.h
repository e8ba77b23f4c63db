#pragma once
/* Adjacent receivers of a rectangle's light, and intermediate results. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define UNOCCLUDED_LANES 32
#define UNOCCLUDED_TINY  1e-36f
/* From this height on, per (distance + size), rounding puts no corner of the light below the
 * horizon. */
#define UNOCCLUDED_ABOVE 1e-5f

struct unoccluded_chunk {
    float half[2];                                  /* half-sides; they add up to 1 */
    _Alignas(64) float centre[3][UNOCCLUDED_LANES]; /* from the receiver */
    float normal[3][UNOCCLUDED_LANES];
    float front[UNOCCLUDED_LANES]; /* how far the receiver is in front of the light's plane */
    float up[UNOCCLUDED_LANES], up_u[UNOCCLUDED_LANES], up_v[UNOCCLUDED_LANES]; /* n . points */
    float across_u[UNOCCLUDED_LANES], across_v[UNOCCLUDED_LANES]; /* 2 centre . half_u, _v */
    float squared[UNOCCLUDED_LANES];
    float reach[UNOCCLUDED_LANES]; /* from the eye to the receiver and to the centre, together */
    float leave[3][UNOCCLUDED_LANES],
        enter[3][UNOCCLUDED_LANES]; /* where the outline sets, rises */
    float polygon[UNOCCLUDED_LANES], sum[UNOCCLUDED_LANES], share[UNOCCLUDED_LANES];
    int32_t far[UNOCCLUDED_LANES];
};

/* Returns whether the light is above receiver i's horizon, beyond any rounding. */
static inline int32_t unoccluded_is_open(const struct unoccluded_chunk *c, size_t i)
{
    const float x = fabsf(c->centre[0][i]), y = fabsf(c->centre[1][i]);
    const float size = 1.0f + x + y + fabsf(c->centre[2][i]);
    return c->up[i] - fabsf(c->up_u[i]) - fabsf(c->up_v[i]) > UNOCCLUDED_ABOVE * size;
}
