#include "worker/trace/path/glossy_lobes.h"

#include <math.h>
#include <string.h>

#include "worker/shade/direction.h"
#include "worker/shade/glossy.h"

/* Lays an anisotropic lobe along the tangent or across it. */
static void stretch(const struct path_vertex *v, int i, const float alpha[2],
                    struct glossy_lobes *out)
{
    const bool along = alpha[0] > alpha[1];
    const struct lanes3 *t = along ? &v->tangent : &v->bitangent;
    out->alpha[i] = sqrtf(alpha[0] * alpha[1]);
    out->stretch[i] = along ? alpha[1] / alpha[0] : alpha[0] / alpha[1];
    out->tangent.x[i] = t->x[i];
    out->tangent.y[i] = t->y[i];
    out->tangent.z[i] = t->z[i];
}

void glossy_lobes_find(const struct path_vertex *v, struct glossy_lobes *out)
{
    memset(out, 0, sizeof *out);
    for (int i = 0; v->any_general && i < LANES; i++) {
        float albedo[3], alpha[2];
        const bool general = v->active.on[i] && !v->lambert.on[i];
        if (!general || !(v->back.z[i] >= DIRECTION_GRAZING) || !glossy_has(&v->bsdf[i])) continue;
        const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]};
        glossy_reflectance(&v->bsdf[i], wo, albedo);
        glossy_alphas(&v->bsdf[i], alpha);
        out->on.on[i] = -1;
        out->reflectance.x[i] = albedo[0];
        out->reflectance.y[i] = albedo[1];
        out->reflectance.z[i] = albedo[2];
        out->alpha[i] = alpha[0];
        if (alpha[0] != alpha[1]) stretch(v, i, alpha, out);
    }
}
