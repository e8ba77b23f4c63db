#pragma once
/* Next-event estimation: the light samples of paths. path_nee_lights.c takes them, path_nee_sky.c
 * those of the environment, path_nee.c finds what is reflected of them. */
#include "worker/trace/path/light_choice.h"
#include "worker/trace/path/path.h"

/* The light that each lane samples. */
struct light_selection {
    uint32_t chosen[LANES]; /* light_table.h; UINT32_MAX: nothing */
    _Alignas(LANES_ALIGN) float probability[LANES];
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES], pick[LANES];
    _Alignas(LANES_ALIGN) float which[LANES]; /* the number that chose, of all but the sky */
    struct light_choice choice;
    _Alignas(LANES_ALIGN) float soft[LANES]; /* share that is the soft sky's */
    uint64_t plan_lights;                    /* bits: lights of the plan that a lane chose */
    bool others;                             /* a lane chose emitters or the environment */
};

/* What sixteen light samples draw their numbers by: sample[i] of key[i] (pattern_path.h). */
struct path_numbers {
    const uint32_t *key, *sample;
};

/* Takes one light sample in each active lane of *v, which has its sky_table, weights and
 * sky_share. */
void path_nee_sample(const struct path_context *c, struct path_numbers n,
                     const struct path_vertex *v, struct light_selection *selection,
                     struct nee_sample *out);

/* Takes a sample of a light without extent in each active lane. */
void path_nee_sample_point(const struct path_context *c, const struct light *light,
                           const struct path_vertex *v, struct light_selection *selection,
                           struct nee_sample *out);

/* Decides whether lane i needs a ray to a sample at `way` from its surface, of length `along`, and
 * sets its cosine. False: the sample lies below the horizon. */
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

/* Samples the environment in the lanes that chose it. */
void path_nee_sample_sky(const struct path_context *c, const struct path_vertex *v,
                         struct light_selection *selection, struct nee_sample *out);
