#pragma once
/* The inner loops of path_kernels over an environment: directions to places of a map, and back. */
#include "worker/trace/light/sky.h"

/* Finds the places of the world's directions on the map. */
static void kernel_find_sky(const struct sky *restrict sky, const float *restrict x,
                            const float *restrict y, const float *restrict z,
                            struct sky_view *restrict out)
{
    const float cosine = sky->cosine, sine = sky->sine, width = sky->width, height = sky->height;
    for (int i = 0; i < LANES; i++) {
        const float d[3] = {cosine * x[i] + sine * z[i], y[i], cosine * z[i] - sine * x[i]};
        const struct environment_spot spot = environment_find(d, width, height);
        out->direction.x[i] = d[0];
        out->direction.y[i] = d[1];
        out->direction.z[i] = d[2];
        out->u[i] = spot.u;
        out->v[i] = spot.v;
    }
}

/* Computes the world's directions of places within texels. */
static void kernel_place_sky(const struct sky *restrict sky, const struct sky_texels *restrict t,
                             const float *restrict u, const float *restrict v,
                             struct lanes3 *restrict out)
{
    const float cosine = sky->cosine, sine = sky->sine, width = sky->width;
    for (int i = 0; i < LANES; i++) {
        const struct environment_texel texel = {.near = t->near[i],
                                                .far = t->far[i],
                                                .column = t->column[i],
                                                .below = t->below.on[i] != 0};
        const float at[2] = {u[i], v[i]};
        float d[3];
        environment_place(texel, width, at, d);
        out->x[i] = cosine * d[0] - sine * d[2];
        out->y[i] = d[1];
        out->z[i] = sine * d[0] + cosine * d[2];
    }
}
