#pragma once
/* What the diffuse lobes of sixteen surfaces make of light from given directions. Light fields hold
 * irradiance, which such a lobe weighs where microfacets lie above it (worker/shade/coupling.h). */
#include "worker/shade/lanes.h"

struct path_kernels;
struct path_vertex;
struct layers;

/* Computes pi times the diffuse lobe over its albedo: 1 for Lambert surfaces. `layers` are those of
 * the vertex. Directions are unit vectors; lanes outside *valid get any weight. */
void diffuse_weigh(const struct path_kernels *kernels, const struct path_vertex *vertex,
                   const struct layers *layers, const struct lanes3 *direction,
                   const struct lanes_mask *valid, float weight[LANES]);
