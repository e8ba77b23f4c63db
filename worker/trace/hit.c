#include "worker/trace/hit.h"

#include <math.h>
#include <string.h>

#include "worker/scene/mesh.h"
#include "worker/trace/lane_kernels.h"

/* One hit before lanes are filled: world space, nothing normalised or turned yet. */
struct raw_hit {
    float position[3], facet[3], normal[3];
    float magnitude; /* of offset.h */
};

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void place_on_triangle(const struct mesh_point *p, struct raw_hit *out)
{
    const float *a = p->mesh->positions + (size_t)3 * p->corners[0];
    const float *b = p->mesh->positions + (size_t)3 * p->corners[1];
    const float *c = p->mesh->positions + (size_t)3 * p->corners[2];
    float edge1[3], edge2[3], magnitude = 0.0f;
    for (int i = 0; i < 3; i++) {
        edge1[i] = b[i] - a[i];
        edge2[i] = c[i] - a[i];
        out->position[i] = a[i] + p->weights[1] * edge1[i] + p->weights[2] * edge2[i];
        float ma = fabsf(a[i]), mb = fabsf(b[i]), mc = fabsf(c[i]);
        float m = ma > mb ? ma : mb;
        m = m > mc ? m : mc;
        magnitude = m > magnitude ? m : magnitude;
    }
    out->magnitude = magnitude;
    cross(edge1, edge2, out->facet);
}

/* Interpolated normal, bent by the normal map where there are tangents. */
static void shading_normal(const struct mesh_point *p, const struct material_uv *uv, float out[3])
{
    const struct mesh_view *mesh = p->mesh;
    for (size_t i = 0; i < 3; i++) out[i] = mesh_interpolate(p, mesh->normals, 3, i);
    if (!mesh->tangents) return;
    float tangent[4], bitangent[3], bend[3];
    for (size_t i = 0; i < 4; i++) tangent[i] = mesh_interpolate(p, mesh->tangents, 4, i);
    cross(out, tangent, bitangent);
    float sign = tangent[3] < 0.0f ? -1.0f : 1.0f;
    material_tangent_normal(mesh->material, uv, bend);
    for (int i = 0; i < 3; i++)
        out[i] = bend[0] * tangent[i] + bend[1] * sign * bitangent[i] + bend[2] * out[i];
}

/* Normals transform by the inverse transpose: the cofactors over the determinant, of which only the
 * sign matters here (glTF: a mirrored node keeps its front). */
static void transform_normal(const float m[12], const float cofactors[9], float n[3])
{
    float det = m[0] * cofactors[0] + m[1] * cofactors[1] + m[2] * cofactors[2];
    float sign = det < 0.0f ? -1.0f : 1.0f;
    float x = n[0], y = n[1], z = n[2];
    for (int i = 0; i < 3; i++)
        n[i] = sign * (cofactors[3 * i] * x + cofactors[3 * i + 1] * y + cofactors[3 * i + 2] * z);
}

static void to_world(const float m[12], bool smooth, struct raw_hit *h)
{
    const float rows[3][3] = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}};
    float cofactors[9];
    cross(rows[1], rows[2], cofactors);
    cross(rows[2], rows[0], cofactors + 3);
    cross(rows[0], rows[1], cofactors + 6);
    transform_normal(m, cofactors, h->facet);
    if (smooth) transform_normal(m, cofactors, h->normal);
    float x = h->position[0], y = h->position[1], z = h->position[2], magnitude = 0.0f;
    for (int i = 0; i < 3; i++) {
        const float *row = rows[i];
        h->position[i] = row[0] * x + row[1] * y + row[2] * z + m[4 * i + 3];
        float sum =
            (fabsf(row[0]) + fabsf(row[1]) + fabsf(row[2])) * h->magnitude + fabsf(m[4 * i + 3]);
        magnitude = sum > magnitude ? sum : magnitude;
    }
    h->magnitude = magnitude;
}

static void put(struct lanes3 *to, int i, const float v[3])
{
    to->x[i] = v[0];
    to->y[i] = v[1];
    to->z[i] = v[2];
}

/* Albedo and emission. `front`: the ray came from the side that the winding faces. */
static void shade(const struct mesh_view *mesh, const struct material_uv *uv, bool front, int i,
                  struct surface *out)
{
    const struct material *m = mesh->material;
    float color[4];
    if (!m->unlit) {
        material_base_color(m, uv, color);
        put(&out->albedo, i, color);
    }
    if (!m->emissive || !(front || m->double_sided || m->unlit)) return;
    material_emission(m, uv, color);
    put(&out->emission, i, color);
}

static void resolve_lane(const struct render_scene *scene, const struct RTCRayHit16 *rays, int i,
                         float magnitude[LANES], struct surface *out)
{
    bool placed = rays->hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID;
    uint32_t index = placed ? rays->hit.instID[0][i] : rays->hit.geomID[i];
    const struct scene_instance *instance = &scene->blob->instances[index];
    const struct mesh_view *mesh = &scene->meshes[instance->mesh];
    struct mesh_point point =
        mesh_point_at(mesh, rays->hit.primID[i], rays->hit.u[i], rays->hit.v[i]);
    struct material_uv uv;
    if (mesh->material->textured) mesh_uv(&point, &uv);
    struct raw_hit h;
    place_on_triangle(&point, &h);
    if (mesh->normals) shading_normal(&point, &uv, h.normal);
    if (placed) to_world(instance->to_world, mesh->normals != NULL, &h);
    if (!mesh->normals) memcpy(h.normal, h.facet, sizeof h.normal);
    bool front = h.facet[0] * rays->ray.dir_x[i] + h.facet[1] * rays->ray.dir_y[i] +
                     h.facet[2] * rays->ray.dir_z[i] <
                 0.0f;
    put(&out->position, i, h.position);
    put(&out->facet, i, h.facet);
    put(&out->normal, i, h.normal);
    magnitude[i] = h.magnitude;
    out->id[i] = index + 1;
    out->light.on[i] = mesh->flags & MESH_IS_LIGHT ? -1 : 0;
    shade(mesh, &uv, front, i, out);
}

void hit_resolve(const struct queries *q, const struct lanes_mask *valid,
                 const struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float magnitude[LANES] = {0};
    memset(out, 0, sizeof *out);
    for (int i = 0; i < LANES; i++) {
        if (!valid->on[i] || rays->hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        out->hit.on[i] = -1;
        out->distance[i] = rays->ray.tfar[i];
        resolve_lane(q->scene, rays, i, magnitude, out);
    }
    q->kernels->finish_surface(&rays->ray, magnitude, out);
}
