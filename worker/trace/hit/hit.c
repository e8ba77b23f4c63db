#include "worker/trace/hit/hit.h"

#include <math.h>

#include "worker/scene/mesh.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/hit/textured.h"

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void get(const struct lanes3 *from, int i, float v[3])
{
    v[0] = from->x[i];
    v[1] = from->y[i];
    v[2] = from->z[i];
}

static void put(struct lanes3 *to, int i, const float v[3])
{
    to->x[i] = v[0];
    to->y[i] = v[1];
    to->z[i] = v[2];
}

static void bend_normal(const struct mesh_point *p, const float bend[3], float n[3])
{
    float tangent[4], bitangent[3];
    for (size_t k = 0; k < 4; k++) tangent[k] = mesh_interpolate(p, p->mesh->tangents, 4, k);
    cross(n, tangent, bitangent);
    float sign = tangent[3] < 0.0f ? -1.0f : 1.0f;
    for (int k = 0; k < 3; k++)
        n[k] = bend[0] * tangent[k] + bend[1] * sign * bitangent[k] + bend[2] * n[k];
}

void hit_bend_normal(const struct mesh_point *p, const float bend[3], int i, struct surface *out)
{
    float n[3];
    get(&out->normal, i, n);
    bend_normal(p, bend, n);
    put(&out->normal, i, n);
}

/* Normals transform by the inverse transpose: the cofactors over the determinant, of which only the
 * sign matters here (glTF: a mirrored node keeps its front). */
static void transform(const float cofactors[9], float sign, const float n[3], float out[3])
{
    for (int k = 0; k < 3; k++) {
        const float *row = cofactors + (size_t)3 * (size_t)k;
        out[k] = sign * (row[0] * n[0] + row[1] * n[1] + row[2] * n[2]);
    }
}

static void transform_normal(const float cofactors[9], float sign, struct lanes3 *lanes, int i)
{
    float n[3], out[3];
    get(lanes, i, n);
    transform(cofactors, sign, n, out);
    put(lanes, i, out);
}

static void transform_position(const float m[12], float *magnitude, struct lanes3 *lanes, int i)
{
    float p[3], out[3], most = 0.0f;
    get(lanes, i, p);
    for (int k = 0; k < 3; k++) {
        const float *row = m + (size_t)4 * (size_t)k;
        out[k] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        float sum = (fabsf(row[0]) + fabsf(row[1]) + fabsf(row[2])) * *magnitude + fabsf(row[3]);
        most = sum > most ? sum : most;
    }
    put(lanes, i, out);
    *magnitude = most;
}

/* Fills the cofactors of a transform; returns the sign of its determinant. */
static float find_cofactors(const float m[12], float cofactors[9])
{
    cross(m + 4, m + 8, cofactors);
    cross(m + 8, m, cofactors + 3);
    cross(m, m + 4, cofactors + 6);
    float det = m[0] * cofactors[0] + m[1] * cofactors[1] + m[2] * cofactors[2];
    return det < 0.0f ? -1.0f : 1.0f;
}

void hit_bend_layer(const struct mesh_point *p, const float bend[3], const float m[12], float n[3])
{
    float own[3], cofactors[9];
    for (size_t k = 0; k < 3; k++) own[k] = mesh_interpolate(p, p->mesh->normals, 3, k);
    bend_normal(p, bend, own);
    const float sign = find_cofactors(m, cofactors);
    transform(cofactors, sign, own, n);
}

void hit_lift_to_world(const float m[12], int i, struct lanes3 *lift, struct lanes3 *round)
{
    float cofactors[9], v[3], out[3];
    float sign = find_cofactors(m, cofactors);
    transform_normal(cofactors, sign, round, i);
    get(lift, i, v);
    for (int k = 0; k < 3; k++, m += 4) out[k] = m[0] * v[0] + m[1] * v[1] + m[2] * v[2];
    put(lift, i, out);
}

void hit_to_world(const float m[12], int i, float *magnitude, struct surface *out)
{
    float cofactors[9];
    float sign = find_cofactors(m, cofactors);
    transform_position(m, magnitude, &out->position, i);
    transform_normal(cofactors, sign, &out->facet, i);
    transform_normal(cofactors, sign, &out->normal, i);
}

void hit_shade_textured(const struct mesh_view *mesh, const struct RTCHit16 *hit, int i,
                        struct surface *out)
{
    const struct material *m = mesh->material;
    struct mesh_point point = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
    struct material_uv uv;
    float v[4];
    mesh_uv(&point, &uv);
    if (mesh->tangents) {
        material_tangent_normal(m, &uv, v);
        hit_bend_normal(&point, v, i, out);
    }
    if (m->lambert) {
        material_base_color(m, &uv, v);
        put(&out->albedo, i, v);
    }
    if (!m->emissive) return;
    material_emission(m, &uv, v);
    put(&out->emission, i, v);
}

void hit_resolve(const struct queries *q, const struct lanes_mask *valid,
                 const struct RTCRayHit16 *rays, struct surface *out)
{
    q->kernels->resolve_hits(q, valid, rays, out);
}

/* Returns the mesh that all lanes met, but for those that met nothing; NULL: there are several, or
 * none. */
static const struct mesh_view *only_mesh(const struct surface *s)
{
    const struct mesh_view *only = NULL;
    for (int i = 0; i < LANES; i++) {
        if (!s->hit.on[i]) continue;
        if (only && s->mesh[i] != only) return NULL;
        only = s->mesh[i];
    }
    return only;
}

void hit_diffuse_albedo(const struct queries *q, const struct RTCRayHit16 *rays, struct surface *s)
{
    const struct RTCHit16 *hit = &rays->hit;
    if (!s->any_bsdf) return;
    const struct mesh_view *only = only_mesh(s);
    if (only && textured_albedo(q->kernels, only, &s->hit, hit, s)) return;
    for (int i = 0; i < LANES; i++) {
        const struct mesh_view *mesh = s->mesh[i];
        struct material_uv uv;
        struct bsdf bsdf;
        if (!s->hit.on[i] || mesh->material->lambert || mesh->material->unlit) continue;
        struct mesh_point point = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
        mesh_uv(&point, &uv);
        material_bsdf(mesh->material, &uv, s->behind.on[i], &bsdf);
        put(&s->albedo, i, bsdf.albedo);
    }
}
