#pragma once
/* The lobes of sixteen surfaces whose light a field of glossy lobes brings: worker/shade/glossy.h
 * names the surfaces. */
#include "worker/trace/path/path.h"

struct glossy_lobes {
    struct lanes_mask on;      /* lanes whose surface has one */
    struct lanes3 reflectance; /* directional albedo; 0 elsewhere */
    _Alignas(LANES_ALIGN) float alpha[LANES];
};

/* Finds the lobes of the active lanes of *v (path_resolve). */
void glossy_lobes_find(const struct path_vertex *v, struct glossy_lobes *out);
