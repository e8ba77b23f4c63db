#include "worker/trace/path/glossy_lobes.h"

#include <string.h>

#include "worker/shade/direction.h"
#include "worker/shade/glossy.h"

void glossy_lobes_find(const struct path_vertex *v, struct glossy_lobes *out)
{
    memset(out, 0, sizeof *out);
    for (int i = 0; v->any_general && i < LANES; i++) {
        float albedo[3];
        const bool general = v->active.on[i] && !v->lambert.on[i];
        if (!general || !(v->back.z[i] >= DIRECTION_GRAZING) || !glossy_has(&v->bsdf[i])) continue;
        glossy_reflectance(&v->bsdf[i], v->back.z[i], albedo);
        out->on.on[i] = -1;
        out->reflectance.x[i] = albedo[0];
        out->reflectance.y[i] = albedo[1];
        out->reflectance.z[i] = albedo[2];
        out->alpha[i] = v->bsdf[i].alpha_u;
    }
}
