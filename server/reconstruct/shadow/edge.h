#pragma once
/* Penumbrae of few pixels, as where things stand on what they shade: there the sheared filter's
 * windows hold little more than the pixel itself. But along the shadow's edge the light field
 * hardly changes, without any shear: a neighbour at Delta, of which nu (nu . Delta) lies across the
 * edge, nu the unit normal of the edge on the light, shows the same blocker at
 *
 *     yhat = y' + eta nu (nu . Delta),
 *
 * so that windows can be long along the edge and no wider than the penumbra across. The edge's
 * direction on the screen is that of the structure tensor of the pixels' own estimates; on the
 * light nu_i is e_i (docs/reconstruction.md, Receiver coordinates) times its normal there. */
#include "server/reconstruct/shadow/wedge.h"

/* How far around the pixels asked for it looks, beside WEDGE_FILL_PX for their slopes. */
#define EDGE_REACH_PX 5

#define EDGE_SIDE (2 * EDGE_REACH_PX + 1)

/* What windows along edges read. Arrays are of the receivers' pixels and hold anything where no
 * pixel asks; of `seen`, points and normals SHADOW_PLANE_PAD more may be read. */
struct edge_field {
    const struct receiver_light *light;
    int32_t width;
    float scale;                        /* m(N) mu */
    const struct shadow_pixels *pixels; /* with wedges */
    const float *seen;                  /* own estimates of what is lit */
    const float *jitter[2];             /* of the strata, below 1 */
    const uint32_t *bits;               /* strata_bits */
    size_t stride;
};

/* What an edge tells of a pixel. */
struct edge_answer {
    float seen; /* -1: nothing */
    float kept; /* how much of the sheared filter's answer stays; 1 where this one says nothing */
    float width_px; /* of the sheared filter */
};

/* Looks along edges around those of `count` pixels whose filter is narrow: at some width and below
 * nothing of the sheared filter's answer is kept. All pixels have a wedge. ERR_MEMORY. */
int edges_filter(const struct receiver_light *light, const struct patch *patch,
                 const struct shadow_kernels *kernels, const struct receivers *receivers,
                 const uint32_t *pixels, uint32_t count, struct edge_answer *out);

/* Both filters' answers as one; the sheared filter's may be -1, too. */
float edge_join(const struct edge_answer *edge, float sheared);
