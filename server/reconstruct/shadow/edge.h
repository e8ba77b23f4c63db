#pragma once
/* Windows along shadow edges. Near contacts a penumbra spans few pixels, and the sheared filter has
 * too few taps. Along the shadow's edge the light field hardly changes, even without shear: a
 * neighbour at Delta shows the same blocker at
 *
 *     yhat = y' + eta nu (nu . Delta),
 *
 * where nu is the unit normal of the edge on the light and nu (nu . Delta) the part of Delta across
 * the edge. Windows can thus be long along the edge and no wider than the penumbra across it. The
 * edge's direction on the screen comes from the structure tensor of the pixels' own estimates; on
 * the light nu_i is e_i (docs/reconstruction.md, Receiver coordinates) times its normal there. */
#include "server/reconstruct/shadow/wedge.h"

/* How far around its pixels the filter reads, beside WEDGE_FILL_PX for their slopes. */
#define EDGE_REACH_PX 5

#define EDGE_SIDE (2 * EDGE_REACH_PX + 1)

/* What windows along edges read. Arrays cover the receivers' pixels and are undefined at pixels
 * that are not asked for. SHADOW_PLANE_PAD elements past the end of `seen`, points and normals are
 * readable. */
struct edge_field {
    const struct receiver_light *light;
    int32_t width;
    float scale;                        /* m(N) mu */
    const struct shadow_pixels *pixels; /* with wedges */
    const float *seen;                  /* own estimates of the seen fraction */
    const float *jitter[2];             /* of the strata, below 1 */
    const uint32_t *bits;               /* strata_bits */
    size_t stride;
};

/* The answer of a pixel's edge window. */
struct edge_answer {
    float seen;     /* -1: no edge was found */
    float kept;     /* share of the sheared filter's answer that is kept; 1 without an edge */
    float width_px; /* of the sheared filter */
};

/* Filters along edges around those of `count` pixels whose filter is narrow. Below a certain width
 * `kept` is 0, and the sheared filter is not needed. All pixels have a wedge. ERR_MEMORY. */
int edges_filter(const struct receiver_light *light, const struct patch *patch,
                 const struct shadow_kernels *kernels, const struct receivers *receivers,
                 const uint32_t *pixels, uint32_t count, struct edge_answer *out);

/* Returns the mean of both filters' answers by edge->kept. Either may be -1. */
float edge_join(const struct edge_answer *edge, float sheared);
