#pragma once
/* hit_kernels' resolve_hits. */
#include <math.h>

#include "worker/scene/movers.h"
#include "worker/trace/hit/hit.h"
#include "worker/trace/hit/lift_lanes.h"
#include "worker/trace/hit/surface_lanes.h"
#include "worker/trace/hit/textured.h"

/* What each lane hit. */
struct hit_lanes {
    struct lanes_mask placed; /* through an Embree instance: the mesh's space is not the world's */
    const float *to_world[LANES];
    struct lanes_mask bent; /* a mesh that bends in the shutter, elsewhere than in its middle */
    bool any_bent;
    float moved[LANES][12];        /* transforms of lanes on what moves as a whole */
    const struct mesh_view **mesh; /* the surface's */
    bool any_hit, any_placed;
    uint32_t traits;              /* enum mesh_trait: of any surface */
    bool one;                     /* all sixteen met the same instance */
    const struct mesh_view *only; /* all lanes' that met anything; NULL: there are several */
};

static inline void put_color(const float v[3], int i, struct lanes3 *to)
{
    to->x[i] = v[0];
    to->y[i] = v[1];
    to->z[i] = v[2];
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

/* Shades lanes that are all on one material without textures. */
static void shade_alike(const struct material *m, struct surface *out)
{
    float radiance[3];
    spread(m->shown, &out->albedo);
    if (!m->emissive) return;
    material_emission(m, NULL, radiance);
    spread(radiance, &out->emission);
}

/* Sets albedos without textures; 0 in lanes that met nothing. */
static void show_plain(const struct hit_lanes *lanes, struct lanes3 *albedo)
{
    static const float nothing[3] = {0.0f, 0.0f, 0.0f};
    for (int i = 0; i < LANES; i++)
        put_color(lanes->mesh[i] ? lanes->mesh[i]->material->shown : nothing, i, albedo);
}

static void shine(const struct material *m, int i, struct lanes3 *emission)
{
    float radiance[3];
    material_emission(m, NULL, radiance);
    put_color(radiance, i, emission);
}

/* Shades in the mesh's space, where normal maps bend. */
static void shade(const struct queries *q, const struct hit_lanes *lanes,
                  const struct RTCHit16 *hit, struct surface *out)
{
    if (lanes->one && !lanes->mesh[0]->material->textured) {
        shade_alike(lanes->mesh[0]->material, out);
        return;
    }
    show_plain(lanes, &out->albedo);
    if (lanes->only && lanes->only->material->textured) {
        textured_shade(q->kernels, lanes->only, &out->hit, hit, out);
        return;
    }
    for (int i = 0; lanes->traits & (MESH_TEXTURED | MESH_SHINES) && i < LANES; i++) {
        const struct mesh_view *mesh = lanes->mesh[i];
        if (mesh && mesh->material->textured)
            hit_shade_textured(mesh, hit, i, out);
        else if (mesh && mesh->material->emissive)
            shine(mesh->material, i, &out->emission);
    }
}

/* Hides emission of the side that the winding turns away, unless the material has two sides. */
static void hide_emission(struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        if (!s->mesh[i]) continue;
        const struct material *m = s->mesh[i]->material;
        if (!s->behind.on[i] || m->double_sided || m->unlit) continue;
        s->emission.x[i] = s->emission.y[i] = s->emission.z[i] = 0.0f;
    }
}

/* Finds which side each ray came from. Facets still point where the winding says. */
static void find_sides(const struct RTCRay16 *r, struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        float along =
            s->facet.x[i] * r->dir_x[i] + s->facet.y[i] * r->dir_y[i] + s->facet.z[i] * r->dir_z[i];
        s->behind.on[i] = -(along >= 0.0f) & s->hit.on[i];
    }
}

/* Returns whether all lanes met one instance, as those of a block mostly do. */
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

/* Returns whether all lanes met one triangle, as camera rays of a block mostly do. Its corners are
 * then read only once. */
static bool is_one_triangle(const struct RTCHit16 *hit)
{
    uint32_t differs = 0;
    for (int i = 1; i < LANES; i++) differs |= hit->primID[i] ^ hit->primID[0];
    return differs == 0;
}

static uint32_t index_of(const struct RTCHit16 *hit, int i)
{
    return hit->instID[0][i] != RTC_INVALID_GEOMETRY_ID ? hit->instID[0][i] : hit->geomID[i];
}

/* Looks up the first lane's instance, which all lanes share. */
static void find_one(const struct render_scene *scene, const struct RTCRayHit16 *rays,
                     struct hit_lanes *lanes, struct surface *out)
{
    const uint32_t index = index_of(&rays->hit, 0);
    const struct scene_instance *instance = &scene->blob->instances[index];
    const struct mesh_view *mesh = &scene->meshes[instance->mesh];
    const int32_t light = mesh->flags & MESH_IS_LIGHT ? -1 : 0;
    lanes->any_hit = true;
    lanes->any_placed = rays->hit.instID[0][0] != RTC_INVALID_GEOMETRY_ID;
    lanes->traits = mesh->traits;
    lanes->only = mesh;
    for (int i = 0; i < LANES; i++) {
        lanes->mesh[i] = mesh;
        lanes->to_world[i] = instance->to_world;
        lanes->placed.on[i] = lanes->any_placed ? -1 : 0;
        out->id[i] = index + 1;
        out->light.on[i] = light;
        out->distance[i] = rays->ray.tfar[i];
        out->hit.on[i] = -1;
    }
}

/* Finds which lanes met something. On triangles too large for floats the products that give the
 * distance have overflowed. */
static void find_hits(const struct lanes_mask *restrict valid,
                      const struct RTCRayHit16 *restrict rays, struct surface *restrict out)
{
    for (int i = 0; i < LANES; i++) {
        const float distance = rays->ray.tfar[i];
        const int on =
            (rays->hit.geomID[i] != RTC_INVALID_GEOMETRY_ID) & (distance < INFINITY) & valid->on[i];
        out->hit.on[i] = -on;
        out->distance[i] = on ? distance : 0.0f;
    }
}

/* Looks up what was hit. Lanes that met nothing look at the first instance, since a branch that
 * scattered rays decide costs more. */
static void find(const struct render_scene *scene, const struct lanes_mask *valid,
                 const struct RTCRayHit16 *rays, struct hit_lanes *lanes, struct surface *out)
{
    const struct RTCHit16 *hit = &rays->hit;
    const struct mesh_view *first = NULL;
    uint32_t traits = 0, placed = 0, several = 0;
    find_hits(valid, rays, out);
    lanes->any_hit = lanes_count(&out->hit) > 0;
    for (int i = 0; lanes->any_hit && i < LANES; i++) {
        const uint32_t on = (uint32_t)out->hit.on[i], index = index_of(hit, i) & on;
        const struct scene_instance *instance = &scene->blob->instances[index];
        const struct mesh_view *mesh = &scene->meshes[instance->mesh];
        const uint32_t other = on & -(uint32_t)(hit->instID[0][i] != RTC_INVALID_GEOMETRY_ID);
        first = first || !on ? first : mesh;
        several |= on & (uint32_t)(mesh != first);
        traits |= on & mesh->traits;
        placed |= other;
        lanes->mesh[i] = on ? mesh : NULL;
        lanes->to_world[i] = instance->to_world;
        lanes->placed.on[i] = (int32_t)other;
        out->id[i] = (index + 1) & on;
        out->light.on[i] = (int32_t)(on & -(uint32_t)((mesh->flags & MESH_IS_LIGHT) != 0));
    }
    lanes->traits = traits;
    lanes->any_placed = placed != 0;
    lanes->only = several ? NULL : first;
}

/* Finds where lanes on what moves are at their rays' times. */
static void find_moved(const struct render_scene *scene, const struct RTCRayHit16 *rays,
                       const struct surface *s, struct hit_lanes *lanes)
{
    lanes->any_bent = false;
    if (!scene->steps) return;
    for (int i = 0; i < LANES; i++) {
        const uint32_t index = s->id[i] - 1;
        const struct scene_step *steps = s->hit.on[i] ? mover_steps(scene, index) : NULL;
        lanes->bent.on[i] = steps && mover_bends(steps) ? -1 : 0;
        lanes->any_bent = lanes->any_bent || lanes->bent.on[i];
        if (!steps || lanes->bent.on[i]) continue;
        mover_to_world(scene, index, rays->ray.time[i], lanes->moved[i]);
        lanes->to_world[i] = lanes->moved[i];
    }
}

static inline struct vector vector_at(const float *v)
{
    return (struct vector){v[0], v[1], v[2]};
}

/* Places the lanes of bent meshes on their triangles as these are at the rays' times. */
static void place_bent(const struct render_scene *scene, const struct hit_lanes *lanes,
                       const struct RTCRayHit16 *rays, bool bent_normals, float *magnitude,
                       struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        float v[9], n[9];
        struct vector position, facet;
        if (!lanes->bent.on[i]) continue;
        const float u = rays->hit.u[i], w = rays->hit.v[i];
        mover_corners(scene, s->id[i] - 1, rays->hit.primID[i], rays->ray.time[i], v, n);
        magnitude[i] =
            place_lane(vector_at(v), vector_at(v + 3), vector_at(v + 6), u, w, &position, &facet);
        lane_put(position, i, &s->position);
        lane_put(facet, i, &s->facet);
        if (!bent_normals) continue;
        lane_put(lanes->mesh[i]->normals
                     ? interpolated(vector_at(n), vector_at(n + 3), vector_at(n + 6), u, w)
                     : facet,
                 i, &s->normal);
    }
}

/* Does the same for lifts. */
static void lift_bent(const struct render_scene *scene, const struct hit_lanes *lanes,
                      const struct RTCRayHit16 *rays, const struct surface *s, struct lift_lanes *l)
{
    for (int i = 0; i < LANES; i++) {
        float v[9], n[9];
        if (!lanes->bent.on[i] || !(lanes->mesh[i]->traits & MESH_ROUND)) continue;
        mover_corners(scene, s->id[i] - 1, rays->hit.primID[i], rays->ray.time[i], v, n);
        for (int k = 0; k < 3; k++) {
            lane_put(vector_at(v + 3 * k), i, &l->place.corner[k]);
            lane_put(vector_at(n + 3 * k), i, &l->normal.corner[k]);
        }
    }
}

/* Clears emission, and where no lane met anything all else that readers look at. */
static void clear(const struct hit_lanes *lanes, struct surface *s)
{
    memset(&s->emission, 0, sizeof s->emission);
    if (lanes->any_hit) return;
    memset(&s->albedo, 0, sizeof s->albedo);
    memset(s->id, 0, sizeof s->id);
    memset(&s->light, 0, sizeof s->light);
    memset(s->mesh, 0, sizeof s->mesh);
}

/* Places the lanes on one triangle. All share the facet and its unit vector. */
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

/* Places lanes that are all on one triangle, which no instance moves and no normal map bends, from
 * corners to surfaces in one go. Returns false, and does nothing, where the triangle has no facet
 * to speak of. */
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

/* Lifts the origins on round meshes, once vectors and sides are final. */
static void lift(const struct render_scene *scene, const struct hit_lanes *lanes,
                 const struct RTCRayHit16 *rays, struct surface *s)
{
    struct lift_lanes l;
    if (!(lanes->traits & MESH_ROUND)) return;
    find_round_corners(lanes->mesh, &rays->hit, &l);
    if (lanes->any_bent) lift_bent(scene, lanes, rays, s, &l);
    find_lifts(s, &rays->hit, &l);
    for (int i = 0; lanes->any_placed && i < LANES; i++)
        if (lanes->mesh[i] && lanes->placed.on[i])
            hit_lift_to_world(lanes->to_world[i], i, &l.lift, &l.round);
    lift_origins(&rays->ray, &l, s);
}

static void kernel_resolve_hits(const struct queries *q, const struct lanes_mask *valid,
                                const struct RTCRayHit16 *rays, struct surface *out)
{
    _Alignas(LANES_ALIGN) float magnitude[LANES];
    struct hit_lanes lanes;
    lanes.mesh = out->mesh;
    lanes.one = is_one(valid, rays);
    if (lanes.one)
        find_one(q->scene, rays, &lanes, out);
    else
        find(q->scene, valid, rays, &lanes, out);
    clear(&lanes, out);
    out->any_bsdf = (lanes.traits & MESH_REFLECTS) != 0;
    out->any_emission = (lanes.traits & MESH_SHINES) != 0;
    if (!lanes.any_hit) return;
    find_moved(q->scene, rays, out, &lanes);
    const bool bent = lanes.traits & MESH_BENT;
    const bool one_triangle = lanes.one && is_one_triangle(&rays->hit);
    if (one_triangle && !lanes.mesh[0]->tangents && !lanes.any_placed && !lanes.any_bent &&
        place_one(lanes.mesh[0], rays, out)) {
        shade(q, &lanes, &rays->hit, out);
        if (lanes.traits & MESH_SHINES) hide_emission(out);
        lift(q->scene, &lanes, rays, out);
        return;
    }
    gather_surface(lanes.mesh, one_triangle, bent, &rays->hit, magnitude, out);
    if (lanes.any_bent) place_bent(q->scene, &lanes, rays, bent, magnitude, out);
    shade(q, &lanes, &rays->hit, out);
    for (int i = 0; lanes.any_placed && i < LANES; i++)
        if (lanes.mesh[i] && lanes.placed.on[i])
            hit_to_world(lanes.to_world[i], i, &magnitude[i], out);
    find_sides(&rays->ray, out);
    if (lanes.traits & MESH_SHINES) hide_emission(out);
    kernel_finish_surface(&rays->ray, magnitude, !bent, out);
    lift(q->scene, &lanes, rays, out);
}
