#include "worker/trace/hit.h"

#include <math.h>

#include "worker/scene/mesh.h"
#include "worker/trace/lane_kernels.h"

static const float white[3] = {1.0f, 1.0f, 1.0f};

/* What each lane hit. */
struct hit_lanes {
    struct lanes_mask placed; /* through an Embree instance: the mesh's space is not the world's */
    const struct scene_instance *instance[LANES];
    const struct mesh_view **mesh; /* the surface's */
    bool any_hit, any_placed, any_emissive;
    bool any_bent; /* normals other than the facets' */
    bool one;      /* all sixteen met the same instance */
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

static void to_world(const float m[12], int i, float *magnitude, struct surface *out)
{
    float cofactors[9];
    cross(m + 4, m + 8, cofactors);
    cross(m + 8, m, cofactors + 3);
    cross(m, m + 4, cofactors + 6);
    float det = m[0] * cofactors[0] + m[1] * cofactors[1] + m[2] * cofactors[2];
    float sign = det < 0.0f ? -1.0f : 1.0f;
    transform_position(m, magnitude, &out->position, i);
    transform_normal(cofactors, sign, &out->facet, i);
    transform_normal(cofactors, sign, &out->normal, i);
}

/* Normal map, albedo and emission (of the emitting side) of a lane whose material has textures. */
static void shade_textured(const struct mesh_view *mesh, const struct RTCHit16 *hit, int i,
                           struct surface *out)
{
    const struct material *m = mesh->material;
    struct mesh_point point = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
    struct material_uv uv;
    float v[4];
    mesh_uv(&point, &uv);
    if (mesh->tangents) {
        get(&out->normal, i, v);
        map_normal(&point, &uv, v);
        put(&out->normal, i, v);
    }
    if (m->lambert) {
        material_base_color(m, &uv, v);
        put(&out->albedo, i, v);
    } else if (!m->unlit) {
        put(&out->albedo, i, white);
    }
    if (!m->emissive) return;
    material_emission(m, &uv, v);
    put(&out->emission, i, v);
}

static void spread(const float v[3], struct lanes3 *out)
{
    const float x = v[0], y = v[1], z = v[2];
    for (int i = 0; i < LANES; i++) {
        out->x[i] = x;
        out->y[i] = y;
        out->z[i] = z;
    }
}

/* All lanes on one material without textures. */
static void shade_alike(const struct material *m, struct surface *out)
{
    float radiance[3];
    if (!m->unlit) spread(m->lambert ? m->base_color : white, &out->albedo);
    if (!m->emissive) return;
    material_emission(m, NULL, radiance);
    spread(radiance, &out->emission);
}

/* In the mesh's space: normal maps bend there. */
static void shade(const struct hit_lanes *lanes, const struct RTCHit16 *hit, struct surface *out)
{
    if (lanes->one && !lanes->mesh[0]->material->textured) {
        shade_alike(lanes->mesh[0]->material, out);
        return;
    }
    for (int i = 0; i < LANES; i++) {
        const struct mesh_view *mesh = lanes->mesh[i];
        if (!mesh) continue;
        const struct material *m = mesh->material;
        if (m->textured) {
            shade_textured(mesh, hit, i, out);
            continue;
        }
        float radiance[3];
        if (!m->unlit) put(&out->albedo, i, m->lambert ? m->base_color : white);
        if (!m->emissive) continue;
        material_emission(m, NULL, radiance);
        put(&out->emission, i, radiance);
    }
}

/* Emission leaves the side that the winding faces, unless the material has two sides. */
static void hide_emission(struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        if (!s->mesh[i]) continue;
        const struct material *m = s->mesh[i]->material;
        if (!s->behind.on[i] || m->double_sided || m->unlit) continue;
        s->emission.x[i] = s->emission.y[i] = s->emission.z[i] = 0.0f;
    }
}

/* Facets still point where the winding says. */
static void find_sides(const struct RTCRay16 *r, struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        float along =
            s->facet.x[i] * r->dir_x[i] + s->facet.y[i] * r->dir_y[i] + s->facet.z[i] * r->dir_z[i];
        s->behind.on[i] = -(along >= 0.0f) & s->hit.on[i];
    }
}

static void find_lane(const struct render_scene *scene, const struct RTCHit16 *hit, int i,
                      struct hit_lanes *lanes, struct surface *out)
{
    bool placed = hit->instID[0][i] != RTC_INVALID_GEOMETRY_ID;
    uint32_t index = placed ? hit->instID[0][i] : hit->geomID[i];
    const struct scene_instance *instance = &scene->blob->instances[index];
    const struct mesh_view *mesh = &scene->meshes[instance->mesh];
    lanes->mesh[i] = mesh;
    lanes->instance[i] = instance;
    lanes->placed.on[i] = placed ? -1 : 0;
    lanes->any_placed |= placed;
    lanes->any_emissive |= mesh->material->emissive;
    lanes->any_bent |= mesh->normals || mesh->tangents;
    out->id[i] = index + 1;
    out->light.on[i] = mesh->flags & MESH_IS_LIGHT ? -1 : 0;
}

/* Whether all lanes met one instance, as those of a block mostly do. */
static bool is_one(const struct lanes_mask *valid, const struct RTCRayHit16 *rays)
{
    const struct RTCHit16 *hit = &rays->hit;
    uint32_t differs = 0;
    int32_t all = -1;
    for (int i = 0; i < LANES; i++) {
        differs |= hit->geomID[i] ^ hit->geomID[0];
        differs |= hit->instID[0][i] ^ hit->instID[0][0];
        all &= valid->on[i] & -(rays->ray.tfar[i] < INFINITY);
    }
    return all && differs == 0 && hit->geomID[0] != RTC_INVALID_GEOMETRY_ID;
}

/* The first lane's instance is everyone's. */
static void find_one(const struct render_scene *scene, const struct RTCRayHit16 *rays,
                     struct hit_lanes *lanes, struct surface *out)
{
    lanes->any_hit = true;
    find_lane(scene, &rays->hit, 0, lanes, out);
    const struct mesh_view *mesh = lanes->mesh[0];
    const struct scene_instance *instance = lanes->instance[0];
    const uint32_t id = out->id[0];
    const int32_t placed = lanes->placed.on[0], light = out->light.on[0];
    for (int i = 0; i < LANES; i++) {
        lanes->mesh[i] = mesh;
        lanes->instance[i] = instance;
        lanes->placed.on[i] = placed;
        out->id[i] = id;
        out->light.on[i] = light;
        out->distance[i] = rays->ray.tfar[i];
        out->hit.on[i] = -1;
    }
}

/* Looks up what was hit; neighbouring lanes mostly hit the same. */
static void find(const struct render_scene *scene, const struct lanes_mask *valid,
                 const struct RTCRayHit16 *rays, struct hit_lanes *lanes, struct surface *out)
{
    const struct RTCHit16 *hit = &rays->hit;
    int last = -1;
    for (int i = 0; i < LANES; i++) {
        lanes->mesh[i] = NULL;
        if (!valid->on[i] || hit->geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        /* Triangles too large for floats: the products that give the distance overflowed. */
        if (!(rays->ray.tfar[i] < INFINITY)) continue;
        lanes->any_hit = true;
        out->hit.on[i] = -1;
        out->distance[i] = rays->ray.tfar[i];
        if (last >= 0 && hit->geomID[i] == hit->geomID[last] &&
            hit->instID[0][i] == hit->instID[0][last]) {
            lanes->mesh[i] = lanes->mesh[last];
            lanes->instance[i] = lanes->instance[last];
            lanes->placed.on[i] = lanes->placed.on[last];
            out->id[i] = out->id[last];
            out->light.on[i] = out->light.on[last];
        } else {
            find_lane(scene, hit, i, lanes, out);
        }
        last = i;
    }
}

/* What lanes without a hit must read as nothing; the rest is written where anything was hit. */
static void clear(struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        s->albedo.x[i] = s->albedo.y[i] = s->albedo.z[i] = 0.0f;
        s->emission.x[i] = s->emission.y[i] = s->emission.z[i] = 0.0f;
        s->distance[i] = 0.0f;
        s->id[i] = 0;
        s->hit.on[i] = s->light.on[i] = 0;
    }
}

void hit_resolve(const struct queries *q, const struct lanes_mask *valid,
                 const struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float magnitude[LANES];
    struct hit_lanes lanes;
    lanes.mesh = out->mesh;
    lanes.any_hit = lanes.any_placed = lanes.any_emissive = lanes.any_bent = false;
    lanes.one = is_one(valid, rays);
    clear(out);
    if (lanes.one)
        find_one(q->scene, rays, &lanes, out);
    else
        find(q->scene, valid, rays, &lanes, out);
    if (!lanes.any_hit) return;
    q->kernels->gather_surface(lanes.mesh, &rays->hit, magnitude, out);
    shade(&lanes, &rays->hit, out);
    for (int i = 0; lanes.any_placed && i < LANES; i++)
        if (lanes.mesh[i] && lanes.placed.on[i])
            to_world(lanes.instance[i]->to_world, i, &magnitude[i], out);
    find_sides(&rays->ray, out);
    if (lanes.any_emissive) hide_emission(out);
    q->kernels->finish_surface(&rays->ray, magnitude, !lanes.any_bent, out);
}

void hit_diffuse_albedo(const struct RTCRayHit16 *rays, struct surface *s)
{
    const struct RTCHit16 *hit = &rays->hit;
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
