#pragma once
/* What the steps of a path's light sample share: path_nee.c, and path_nee_sky.c for the
 * environment.
 */
#include "worker/trace/path/path.h"

/* What each lane is to try. */
struct light_selection {
    uint32_t chosen[LANES]; /* light_table_choose; UINT32_MAX: nothing */
    _Alignas(LANES_ALIGN) float probability[LANES];
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES], pick[LANES];
    _Alignas(LANES_ALIGN) float soft[LANES]; /* share that is the soft sky's */
    uint64_t plan_lights;                    /* bits: chosen by some lane */
    bool others;                             /* emitters or environment are */
};

/* The direction of the ray to a sample at `way` from lane i's surface, with the cosines that decide
 * whether it is needed. */
static inline bool path_nee_aim(const struct path_vertex *v, int i, const float way[3], float along,
                                struct light_packet *p)
{
    const struct surface *s = &v->surface;
    float shading = way[0] * s->normal.x[i] + way[1] * s->normal.y[i] + way[2] * s->normal.z[i];
    float facet = way[0] * s->facet.x[i] + way[1] * s->facet.y[i] + way[2] * s->facet.z[i];
    bool above = shading > 0.0f && facet > 0.0f;
    p->skip[i] = above ? LIGHT_TRACED : LIGHT_BELOW_HORIZON;
    p->irradiance[i] = shading / along; /* the cosine; the caller divides by the density */
    return above;
}

/* Lanes that chose the environment. */
void path_nee_sample_sky(const struct path_context *c, const struct path_vertex *v,
                         struct light_selection *selection, struct nee_sample *out);
