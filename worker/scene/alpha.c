#include "worker/scene/alpha.h"

#include <embree3/rtcore.h>

#include "worker/scene/mesh.h"

/* Mixes 64 bits by a bijection in which every input bit moves every output bit: two rounds of
 * multiply and xor-shift with the constants of Stafford's variant 13. */
static uint64_t mix(uint64_t v)
{
    v = (v ^ v >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    v = (v ^ v >> 27) * UINT64_C(0x94d049bb133111eb);
    return v ^ v >> 31;
}

/* Draws a number of 24 bits for a ray and a surface. It stays below 1, so that a surface of opacity
 * 1 is always met. */
static float draw(const struct alpha_hit *hit)
{
    uint64_t surface = (uint64_t)hit->instance << 32 | hit->geometry;
    uint64_t ray = (uint64_t)hit->ray << 32 | hit->triangle;
    return (float)(mix(mix(ray) + surface) >> 40) * 0x1p-24f;
}

bool alpha_covers(const struct mesh_view *mesh, const struct alpha_hit *hit)
{
    const struct material *m = mesh->material;
    struct mesh_point point = mesh_point_at(mesh, hit->triangle, hit->u, hit->v);
    struct material_uv uv;
    mesh_uv(&point, &uv);
    float opacity = material_opacity(m, &uv);
    return m->blend && hit->ray ? draw(hit) < opacity : opacity >= 0.5f;
}

/* Embree has accessors of N-wide rays for C++ only. Fields follow each other, N values each, in the
 * order of struct RTCRay and struct RTCHit. */
enum { RAY_ID = 10 };
enum { HIT_U = 3, HIT_V = 4, HIT_PRIMITIVE = 5, HIT_GEOMETRY = 6, HIT_INSTANCE = 7 };

static uint32_t word(const void *fields, int field, unsigned int lanes, unsigned int lane)
{
    return ((const uint32_t *)fields)[(size_t)field * lanes + lane];
}

static float number(const void *fields, int field, unsigned int lanes, unsigned int lane)
{
    return ((const float *)fields)[(size_t)field * lanes + lane];
}

void alpha_filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct mesh_view *mesh = args->geometryUserPtr;
    const unsigned int n = args->N;
    for (unsigned int i = 0; i < n; i++) {
        if (args->valid[i] != -1) continue;
        const struct alpha_hit hit = {.ray = word(args->ray, RAY_ID, n, i),
                                      .instance = word(args->hit, HIT_INSTANCE, n, i),
                                      .geometry = word(args->hit, HIT_GEOMETRY, n, i),
                                      .triangle = word(args->hit, HIT_PRIMITIVE, n, i),
                                      .u = number(args->hit, HIT_U, n, i),
                                      .v = number(args->hit, HIT_V, n, i)};
        if (!alpha_covers(mesh, &hit)) args->valid[i] = 0;
    }
}
