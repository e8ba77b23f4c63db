#include "worker/trace/path/diffuse_weight.h"

#include "worker/trace/path/path.h"
#include "worker/trace/path/path_kernels.h"

/* It is asked for with a white lobe: where a texture's albedo is black, filters still read what its
 * neighbours can use. Surfaces without such a lobe count as Lambert's, for the sake of other
 * surfaces in their pixel. */
static float weigh_one(const struct path_vertex *v, int i, const float d[3])
{
    struct bsdf white = v->bsdf[i];
    struct bsdf_value value;
    if (white.model == BSDF_BLACK || white.model == BSDF_MIRROR) return 1.0f;
    const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]};
    float wi[3];
    path_to_frame(v, i, d, wi);
    white.albedo[0] = white.albedo[1] = white.albedo[2] = 1.0f;
    bsdf_evaluate(&white, wo, wi, &value);
    return ELEMENTARY_PI * value.diffuse;
}

void diffuse_weigh(const struct path_kernels *kernels, const struct path_vertex *v,
                   const struct layers *layers, const struct lanes3 *direction,
                   const struct lanes_mask *valid, float weight[LANES])
{
    for (int i = 0; i < LANES; i++) weight[i] = 1.0f;
    if (!v->any_general) return;
    kernels->layers_diffuse(v, layers, direction, weight);
    for (int i = 0; layers->others && i < LANES; i++) {
        const float d[3] = {direction->x[i], direction->y[i], direction->z[i]};
        if (valid->on[i] && !v->lambert.on[i] && !layers->on.on[i]) weight[i] = weigh_one(v, i, d);
    }
}
