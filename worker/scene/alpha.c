#include "worker/scene/alpha.h"

#include <embree3/rtcore.h>

#include "worker/scene/mesh.h"

bool alpha_covers(const struct mesh_view *mesh, uint32_t triangle, float u, float v)
{
    struct mesh_point point = mesh_point_at(mesh, triangle, u, v);
    struct material_uv uv;
    mesh_uv(&point, &uv);
    float color[4];
    material_base_color(mesh->material, &uv, color);
    return color[3] >= mesh->material->alpha_cutoff;
}

/* Embree's C headers leave the N-wide accessors to C++: fields follow each other, N values each, in
 * the order of struct RTCHit. */
enum { HIT_U = 3, HIT_V = 4, HIT_PRIMITIVE = 5 };

void alpha_filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct mesh_view *mesh = args->geometryUserPtr;
    const float *u = (const float *)args->hit + (size_t)HIT_U * args->N;
    const float *v = (const float *)args->hit + (size_t)HIT_V * args->N;
    const unsigned int *triangle =
        (const unsigned int *)args->hit + (size_t)HIT_PRIMITIVE * args->N;
    for (unsigned int i = 0; i < args->N; i++)
        if (args->valid[i] == -1 && !alpha_covers(mesh, triangle[i], u[i], v[i]))
            args->valid[i] = 0;
}
