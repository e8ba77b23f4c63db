#pragma once
/* The glossy lobes of sixteen surfaces, for the light field of glossy lobes. worker/shade/glossy.h
 * says which surfaces have one. */
#include "worker/trace/path/path.h"

struct glossy_lobes {
    struct lanes_mask on;                       /* lanes whose surface has one */
    struct lanes3 reflectance;                  /* directional albedo; 0 elsewhere */
    _Alignas(LANES_ALIGN) float alpha[LANES];   /* of anisotropic ones the geometric mean */
    _Alignas(LANES_ALIGN) float stretch[LANES]; /* the smaller alpha over the larger; 0: equal */
    struct lanes3 tangent; /* of the world, along which alpha is larger; where they differ */
};

/* Finds the lobes of the active lanes of *v (path_resolve). */
void glossy_lobes_find(const struct path_vertex *v, struct glossy_lobes *out);
