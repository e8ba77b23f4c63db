#include "worker/trace/hit.h"

#include <math.h>
#include <string.h>

#include "worker/scene/mesh.h"
#include "worker/trace/lane_kernels.h"

/* The lanes that hit one placed mesh. */
struct group {
    uint32_t instance;
    bool placed; /* through an Embree instance: the mesh's space is not the world's */
    const struct scene_instance *record;
    const struct mesh_view *mesh;
    struct lanes_mask mine;
};

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

/* Bends an interpolated normal by the normal map. */
static void map_normal(const struct mesh_point *p, const struct material_uv *uv, float n[3])
{
    float tangent[4], bitangent[3], bend[3];
    for (size_t i = 0; i < 4; i++) tangent[i] = mesh_interpolate(p, p->mesh->tangents, 4, i);
    cross(n, tangent, bitangent);
    float sign = tangent[3] < 0.0f ? -1.0f : 1.0f;
    material_tangent_normal(p->mesh->material, uv, bend);
    for (int i = 0; i < 3; i++)
        n[i] = bend[0] * tangent[i] + bend[1] * sign * bitangent[i] + bend[2] * n[i];
}

/* Normals transform by the inverse transpose: the cofactors over the determinant, of which only the
 * sign matters here (glTF: a mirrored node keeps its front). */
static void transform_normal(const float cofactors[9], float sign, struct lanes3 *lanes, int i)
{
    float n[3], out[3];
    get(lanes, i, n);
    for (int k = 0; k < 3; k++) {
        const float *row = cofactors + (size_t)3 * (size_t)k;
        out[k] = sign * (row[0] * n[0] + row[1] * n[1] + row[2] * n[2]);
    }
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

static void to_world(const struct group *g, float magnitude[LANES], struct surface *out)
{
    const float *m = g->record->to_world;
    float cofactors[9];
    cross(m + 4, m + 8, cofactors);
    cross(m + 8, m, cofactors + 3);
    cross(m, m + 4, cofactors + 6);
    float det = m[0] * cofactors[0] + m[1] * cofactors[1] + m[2] * cofactors[2];
    float sign = det < 0.0f ? -1.0f : 1.0f;
    for (int i = 0; i < LANES; i++) {
        if (!g->mine.on[i]) continue;
        transform_position(m, &magnitude[i], &out->position, i);
        transform_normal(cofactors, sign, &out->facet, i);
        transform_normal(cofactors, sign, &out->normal, i);
    }
}

/* Whether the ray came from the side that the winding faces. */
static bool front(const struct RTCRay16 *r, const struct surface *s, int i)
{
    return s->facet.x[i] * r->dir_x[i] + s->facet.y[i] * r->dir_y[i] + s->facet.z[i] * r->dir_z[i] <
           0.0f;
}

static void emit(const struct group *g, const struct RTCRay16 *r, const struct material_uv *uv,
                 int i, struct surface *out)
{
    const struct material *m = g->mesh->material;
    float radiance[3];
    if (!m->emissive || !(m->double_sided || m->unlit || front(r, out, i))) return;
    material_emission(m, uv, radiance);
    put(&out->emission, i, radiance);
}

/* Material of a mesh without textures: the same in all lanes. */
static void shade_plain(const struct group *g, const struct RTCRay16 *r, struct surface *out)
{
    const struct material *m = g->mesh->material;
    for (int i = 0; i < LANES; i++) {
        int on = g->mine.on[i] && !m->unlit;
        out->albedo.x[i] = on ? m->base_color[0] : out->albedo.x[i];
        out->albedo.y[i] = on ? m->base_color[1] : out->albedo.y[i];
        out->albedo.z[i] = on ? m->base_color[2] : out->albedo.z[i];
    }
    for (int i = 0; m->emissive && i < LANES; i++)
        if (g->mine.on[i]) emit(g, r, NULL, i, out);
}

static void shade_textured(const struct group *g, const struct RTCRayHit16 *q, int i,
                           const struct material_uv *uv, struct surface *out)
{
    float color[4];
    if (!g->mesh->material->unlit) {
        material_base_color(g->mesh->material, uv, color);
        put(&out->albedo, i, color);
    }
    emit(g, &q->ray, uv, i, out);
}

/* Normal maps bend in the mesh's space. */
static void map_normals(const struct group *g, const struct RTCHit16 *hit, struct surface *out)
{
    for (int i = 0; i < LANES; i++) {
        if (!g->mine.on[i]) continue;
        struct mesh_point point = mesh_point_at(g->mesh, hit->primID[i], hit->u[i], hit->v[i]);
        struct material_uv uv;
        float n[3];
        mesh_uv(&point, &uv);
        get(&out->normal, i, n);
        map_normal(&point, &uv, n);
        put(&out->normal, i, n);
    }
}

static void shade(const struct group *g, const struct RTCRayHit16 *q, struct surface *out)
{
    if (!g->mesh->material->textured) {
        shade_plain(g, &q->ray, out);
        return;
    }
    for (int i = 0; i < LANES; i++) {
        if (!g->mine.on[i]) continue;
        struct mesh_point point =
            mesh_point_at(g->mesh, q->hit.primID[i], q->hit.u[i], q->hit.v[i]);
        struct material_uv uv;
        mesh_uv(&point, &uv);
        shade_textured(g, q, i, &uv, out);
    }
}

/* The group of lane `first`: all lanes of `rest` that hit the same placed mesh. They leave `rest`.
 */
static void group_init(struct group *g, const struct render_scene *scene,
                       const struct RTCHit16 *hit, int first, struct lanes_mask *rest)
{
    uint32_t geometry = hit->geomID[first], place = hit->instID[0][first];
    g->placed = place != RTC_INVALID_GEOMETRY_ID;
    g->instance = g->placed ? place : geometry;
    g->record = &scene->blob->instances[g->instance];
    g->mesh = &scene->meshes[g->record->mesh];
    for (int i = 0; i < LANES; i++) {
        int same = (hit->geomID[i] == geometry) & (hit->instID[0][i] == place);
        g->mine.on[i] = same ? rest->on[i] : 0;
        rest->on[i] &= ~g->mine.on[i];
    }
}

static void resolve_group(const struct queries *q, const struct group *g,
                          const struct RTCRayHit16 *rays, float magnitude[LANES],
                          struct surface *out)
{
    int32_t light = g->mesh->flags & MESH_IS_LIGHT ? -1 : 0;
    q->kernels->gather_surface(g->mesh, &rays->hit, &g->mine, magnitude, out);
    if (g->mesh->tangents) map_normals(g, &rays->hit, out);
    if (g->placed) to_world(g, magnitude, out);
    shade(g, rays, out);
    for (int i = 0; i < LANES; i++) {
        out->id[i] = g->mine.on[i] ? g->instance + 1 : out->id[i];
        out->light.on[i] |= g->mine.on[i] & light;
    }
}

void hit_resolve(const struct queries *q, const struct lanes_mask *valid,
                 const struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float magnitude[LANES] = {0};
    struct lanes_mask rest;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < LANES; i++) {
        int32_t hit = rays->hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? 0 : valid->on[i];
        out->hit.on[i] = hit;
        out->distance[i] = hit ? rays->ray.tfar[i] : 0.0f;
        rest.on[i] = hit;
    }
    for (int i = 0; i < LANES; i++) {
        if (!rest.on[i]) continue;
        struct group g;
        group_init(&g, q->scene, &rays->hit, i, &rest);
        resolve_group(q, &g, rays, magnitude, out);
    }
    q->kernels->finish_surface(&rays->ray, magnitude, out);
}
