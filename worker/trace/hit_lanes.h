#pragma once
/* lane_kernels' resolve_hits. Included by lane_kernels_body.h only, after surface_lanes.h. */
#include <math.h>

#include "worker/trace/hit.h"
#include "worker/trace/textured.h"

/* What each lane hit. */
struct hit_lanes {
    struct lanes_mask placed; /* through an Embree instance: the mesh's space is not the world's */
    const struct scene_instance *instance[LANES];
    const struct mesh_view **mesh; /* the surface's */
    bool any_hit, any_placed, any_emissive;
    bool any_bent;                /* normals other than the facets' */
    bool one;                     /* all sixteen met the same instance */
    int meshes;                   /* looked up */
    const struct mesh_view *only; /* all lanes' that met anything; NULL: there are several */
};

static inline void put_color(const float v[3], int i, struct lanes3 *to)
{
    to->x[i] = v[0];
    to->y[i] = v[1];
    to->z[i] = v[2];
}

static const float white[3] = {1.0f, 1.0f, 1.0f};

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
static void shade(const struct queries *q, const struct hit_lanes *lanes,
                  const struct RTCHit16 *hit, struct surface *out)
{
    if (lanes->one && !lanes->mesh[0]->material->textured) {
        shade_alike(lanes->mesh[0]->material, out);
        return;
    }
    if (lanes->only && lanes->only->material->textured) {
        textured_shade(q->kernels, lanes->only, &out->hit, hit, out);
        return;
    }
    for (int i = 0; i < LANES; i++) {
        const struct mesh_view *mesh = lanes->mesh[i];
        if (!mesh) continue;
        const struct material *m = mesh->material;
        if (m->textured) {
            hit_shade_textured(mesh, hit, i, out);
            continue;
        }
        float radiance[3];
        if (!m->unlit) put_color(m->lambert ? m->base_color : white, i, &out->albedo);
        if (!m->emissive) continue;
        material_emission(m, NULL, radiance);
        put_color(radiance, i, &out->emission);
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
    lanes->only = lanes->meshes == 0 || lanes->only == mesh ? mesh : NULL;
    lanes->meshes++;
    lanes->mesh[i] = mesh;
    lanes->instance[i] = instance;
    lanes->placed.on[i] = placed ? -1 : 0;
    lanes->any_placed |= placed;
    lanes->any_emissive |= mesh->material->emissive;
    out->any_bsdf |= !mesh->material->lambert && !mesh->material->unlit;
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

/* Camera rays of a block mostly meet one triangle: then its corners need be read only once. */
static bool is_one_triangle(const struct RTCHit16 *hit)
{
    uint32_t differs = 0;
    for (int i = 1; i < LANES; i++) differs |= hit->primID[i] ^ hit->primID[0];
    return differs == 0;
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

/* The facet and its unit vector are all lanes' own. */
LANE_INLINE void place_on_one(const struct vector *v, const struct vector *n, bool flat,
                              struct vector facet, struct vector unit, float magnitude,
                              const struct RTCRayHit16 *restrict rays, struct surface *restrict s)
{
    for (int i = 0; i < LANES; i++) {
        struct vector position, same, direction = lane_direction(&rays->ray, i);
        const float u = rays->hit.u[i], w = rays->hit.v[i];
        place_lane(v[0], v[1], v[2], u, w, &position, &same);
        lane_put(position, i, &s->position);
        s->behind.on[i] = -(dot(facet, direction) >= 0.0f);
        finish_vectors(direction, position, unit,
                       flat ? unit : interpolated(n[0], n[1], n[2], u, w), magnitude, flat, i, s);
    }
}

static inline void find_corners(const float *attribute, const uint32_t *triangle,
                                struct vector v[3])
{
    for (int k = 0; k < 3; k++) {
        const float *at = attribute + (size_t)3 * triangle[k];
        v[k] = (struct vector){at[0], at[1], at[2]};
    }
}

/* All lanes on one triangle that stays where it is, without a normal map: from corners to surfaces
 * in one go. false, and nothing is done, where the triangle has no facet to speak of. */
static bool place_one(const struct mesh_view *mesh, const struct RTCRayHit16 *restrict rays,
                      struct surface *restrict s)
{
    static const struct vector none = {0.0f, 0.0f, 0.0f};
    const uint32_t *triangle = mesh->triangles + (size_t)3 * rays->hit.primID[0];
    struct vector v[3], n[3], position, facet;
    find_corners(mesh->positions, triangle, v);
    const float magnitude = place_lane(v[0], v[1], v[2], 0.0f, 0.0f, &position, &facet);
    if (!has_direction(facet)) return false;
    const struct vector unit = normalised(facet, none, 1.0f);
    if (!mesh->normals) {
        place_on_one(v, v, true, facet, unit, magnitude, rays, s);
        return true;
    }
    find_corners(mesh->normals, triangle, n);
    place_on_one(v, n, false, facet, unit, magnitude, rays, s);
    return true;
}

static void kernel_resolve_hits(const struct queries *q, const struct lanes_mask *valid,
                                const struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float magnitude[LANES];
    struct hit_lanes lanes;
    lanes.mesh = out->mesh;
    out->any_bsdf = false;
    lanes.meshes = 0;
    lanes.any_hit = lanes.any_placed = lanes.any_emissive = lanes.any_bent = false;
    lanes.one = is_one(valid, rays);
    clear(out);
    if (lanes.one)
        find_one(q->scene, rays, &lanes, out);
    else
        find(q->scene, valid, rays, &lanes, out);
    if (!lanes.any_hit) return;
    const bool one_triangle = lanes.one && is_one_triangle(&rays->hit);
    if (one_triangle && !lanes.mesh[0]->tangents && !lanes.any_placed &&
        place_one(lanes.mesh[0], rays, out)) {
        shade(q, &lanes, &rays->hit, out);
        if (lanes.any_emissive) hide_emission(out);
        return;
    }
    gather_surface(lanes.mesh, one_triangle, &rays->hit, magnitude, out);
    shade(q, &lanes, &rays->hit, out);
    for (int i = 0; lanes.any_placed && i < LANES; i++)
        if (lanes.mesh[i] && lanes.placed.on[i])
            hit_to_world(lanes.instance[i]->to_world, i, &magnitude[i], out);
    find_sides(&rays->ray, out);
    if (lanes.any_emissive) hide_emission(out);
    kernel_finish_surface(&rays->ray, magnitude, !lanes.any_bent, out);
}
