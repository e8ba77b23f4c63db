#pragma once
/* Sixteen rough, opaque glTF surfaces side by side: a diffuse lobe under a layer of microfacets.
 * Most scenes consist of them. The results are the same bits as those of worker/shade/gltf.c.
 * Mirrors, glass and other models are evaluated lane by lane. */
#include <stdbool.h>

#include "worker/shade/lanes.h"

struct path_kernels;
struct path_vertex;

struct layers {
    struct lanes_mask on;            /* lanes that are such; nothing else here holds of others */
    bool any, others;                /* some lane is; some lane with a bsdf is not */
    struct lanes3 albedo, color, f0; /* struct bsdf's albedo, base_color, specular_f0 */
    _Alignas(LANES_ALIGN) float alpha_u[LANES], alpha_v[LANES], metallic[LANES], specular[LANES];
    _Alignas(LANES_ALIGN) float least[LANES]; /* lobe_least */
    /* As seen from where the path came from: */
    _Alignas(LANES_ALIGN) float coat[LANES];    /* specular's weight beside metal's */
    _Alignas(LANES_ALIGN) float most_f0[LANES]; /* the most reflecting colour's */
    _Alignas(LANES_ALIGN) float span[LANES];    /* ggx_span */
    _Alignas(LANES_ALIGN) float kept[LANES];    /* of diffuse light on its way out */
    _Alignas(LANES_ALIGN) float passed[LANES];  /* the same, on average over directions */
    _Alignas(LANES_ALIGN) float p_diffuse[LANES], p_facet[LANES]; /* of choosing the lobe */
};

/* Samples of the facets' lobes. */
struct layer_gloss {
    struct lanes_mask on;           /* lanes that have one */
    struct lanes_mask above;        /* whose direction lies above the facet */
    struct lanes3 weight;           /* f |cos| / pdf of the lobe */
    struct lanes3 local, direction; /* in the shading frame; in the world */
};

/* Sets v->layers for the active lanes of v, which path_resolve has set. */
void layers_see(const struct path_kernels *kernels, const struct path_vertex *v,
                struct layers *out);
