#include "worker/trace/path/layers.h"

#include "worker/shade/direction.h"
#include "worker/shade/lobe.h"
#include "worker/shade/roughness.h"
#include "worker/trace/path/path_kernels.h"

static bool is_layer(const struct bsdf *b)
{
    return b->model == BSDF_GLTF && !(b->transmission > 0.0f) && !bsdf_has_layers(b) &&
           !roughness_is_smooth(b);
}

static void take(const struct bsdf *b, int i, struct layers *l)
{
    float alpha[2];
    roughness_of(b, alpha);
    l->alpha_u[i] = alpha[0];
    l->alpha_v[i] = alpha[1];
    l->least[i] = lobe_least(b->seen, 0.5f * (b->alpha_u + b->alpha_v));
    l->metallic[i] = b->metallic;
    l->specular[i] = b->specular;
    l->albedo.x[i] = b->albedo[0];
    l->albedo.y[i] = b->albedo[1];
    l->albedo.z[i] = b->albedo[2];
    l->color.x[i] = b->base_color[0];
    l->color.y[i] = b->base_color[1];
    l->color.z[i] = b->base_color[2];
    l->f0.x[i] = b->specular_f0[0];
    l->f0.y[i] = b->specular_f0[1];
    l->f0.z[i] = b->specular_f0[2];
}

void layers_see(const struct path_kernels *kernels, const struct path_vertex *v, struct layers *out)
{
    out->any = out->others = false;
    for (int i = 0; i < LANES; i++) {
        const bool general = v->active.on[i] && !v->lambert.on[i];
        const bool on = general && is_layer(&v->bsdf[i]);
        out->on.on[i] = on ? -1 : 0;
        out->any |= on;
        out->others |= general && !on;
        if (on) take(&v->bsdf[i], i, out);
    }
    if (out->any) kernels->layers_see(&v->back, out);
}
