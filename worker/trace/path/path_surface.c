#include <math.h>
#include <string.h>

#include "worker/scene/mesh.h"
#include "worker/scene/movers.h"
#include "worker/shade/direction.h"
#include "worker/trace/path/path.h"
#include "worker/trace/path/path_kernels.h"

/* Computes the mesh's tangent in the world. Returns the sign of its bitangent. */
static float world_tangent(const struct path_context *c, const struct mesh_point *at, uint32_t id,
                           float time, float out[3])
{
    float t[4], to_world[12];
    const float *m = to_world;
    mover_to_world(c->queries->scene, id - 1, time, to_world);
    for (size_t k = 0; k < 4; k++) t[k] = mesh_interpolate(at, at->mesh->tangents, 4, k);
    for (int k = 0; k < 3; k++, m += 4) out[k] = m[0] * t[0] + m[1] * t[1] + m[2] * t[2];
    return t[3] < 0.0f ? -1.0f : 1.0f;
}

/* Aligns the tangents with those that anisotropy refers to: the mesh's, turned by the material. */
static void align_tangents(const struct path_context *c, int i, const struct material_uv *uv,
                           const struct mesh_point *at, float time, struct path_vertex *v)
{
    const struct surface *s = &v->surface;
    const struct mesh_view *mesh = s->mesh[i];
    float direction[2], t[3];
    if (!mesh->tangents) return;
    material_tangent_angle(mesh->material, uv, direction);
    direction[1] *= world_tangent(c, at, s->id[i], time, t);
    float n[3] = {s->normal.x[i], s->normal.y[i], s->normal.z[i]};
    float along = t[0] * n[0] + t[1] * n[1] + t[2] * n[2], squared = 0.0f;
    for (int k = 0; k < 3; k++) t[k] -= along * n[k], squared += t[k] * t[k];
    if (!(squared > 1e-12f)) return;
    const float length = sqrtf(squared);
    for (int k = 0; k < 3; k++) t[k] /= length;
    float b[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]};
    v->tangent.x[i] = direction[0] * t[0] + direction[1] * b[0];
    v->tangent.y[i] = direction[0] * t[1] + direction[1] * b[1];
    v->tangent.z[i] = direction[0] * t[2] + direction[1] * b[2];
    v->bitangent.x[i] = direction[0] * b[0] - direction[1] * t[0];
    v->bitangent.y[i] = direction[0] * b[1] - direction[1] * t[1];
    v->bitangent.z[i] = direction[0] * b[2] - direction[1] * t[2];
}

/* How far a layer's normal leans to the viewer at least, as a cosine. */
#define FACING_MIN 1e-3f

/* Gives the coat its normal: of the mesh, bent by the coat's own map, turned to the viewer as other
 * normals are. */
static void bend_coat(const struct path_context *c, const struct RTCRayHit16 *rays, int i,
                      struct path_vertex *v)
{
    const struct RTCHit16 *hit = &rays->hit;
    const struct surface *s = &v->surface;
    const struct mesh_view *mesh = s->mesh[i];
    const struct mesh_point at = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
    const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]};
    struct bsdf *b = &v->bsdf[i];
    struct material_uv uv;
    float bend[3], n[3], local[3], to_world[12];
    mesh_uv(&at, &uv);
    material_coat_normal(mesh->material, &uv, bend);
    mover_to_world(c->queries->scene, s->id[i] - 1, rays->ray.time[i], to_world);
    hit_bend_layer(&at, bend, to_world, n);
    if (!(direction_normalize(n[0], n[1], n[2], n) > 1e-18f)) return;
    const float side = n[0] * s->plane.x[i] + n[1] * s->plane.y[i] + n[2] * s->plane.z[i];
    for (int k = 0; side < 0.0f && k < 3; k++) n[k] = -n[k];
    path_to_frame(v, i, n, local);
    const float facing = direction_dot(local, wo);
    const float lift = facing < FACING_MIN ? FACING_MIN - facing : 0.0f;
    for (int k = 0; k < 3; k++) local[k] += lift * wo[k];
    direction_normalize(local[0], local[1], local[2], b->coat_normal);
    b->coat_bent = true;
}

static bool has_bent_coat(const struct path_vertex *v, int i)
{
    return v->active.on[i] && !v->lambert.on[i] && v->surface.mesh[i]->material->coat_bent &&
           v->surface.mesh[i]->tangents && v->bsdf[i].coat > 0.0f;
}

static void resolve_general(const struct path_context *c, const struct RTCRayHit16 *rays, int i,
                            struct path_vertex *v)
{
    struct surface *s = &v->surface;
    const struct mesh_view *mesh = s->mesh[i];
    const struct RTCHit16 *hit = &rays->hit;
    const struct material *m = mesh->material;
    struct mesh_point at = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
    struct material_uv uv;
    if (m->textured || m->anisotropic) mesh_uv(&at, &uv);
    material_bsdf(m, &uv, s->behind.on[i], &v->bsdf[i]);
    v->bsdf[i].seen = v->depth == 0;
    v->bsdf[i].turn_least = v->depth == 0 ? c->turn_least : 0.0f;
    if (m->anisotropic) align_tangents(c, i, &uv, &at, rays->ray.time[i], v);
    s->albedo.x[i] = v->bsdf[i].albedo[0];
    s->albedo.y[i] = v->bsdf[i].albedo[1];
    s->albedo.z[i] = v->bsdf[i].albedo[2];
}

void path_resolve(const struct path_context *c, const struct RTCRayHit16 *rays,
                  struct path_vertex *v)
{
    static const struct mesh_view nothing = {.traits = 0};
    for (int i = 0; i < LANES; i++) {
        const struct mesh_view *mesh = v->active.on[i] ? v->surface.mesh[i] : &nothing;
        v->lambert.on[i] = mesh->traits & MESH_LAMBERT ? -1 : 0;
    }
    const uint32_t lambert = lanes_count(&v->lambert);
    v->any_lambert = lambert > 0;
    v->any_general = lanes_count(&v->active) > lambert;
    if (!v->any_general) return;
    c->kernels->tangents(&v->surface.normal, &v->tangent, &v->bitangent);
    for (int i = 0; i < LANES; i++)
        if (v->active.on[i] && !v->lambert.on[i]) resolve_general(c, rays, i, v);
    c->kernels->look_back(&rays->ray, v);
    for (int i = 0; i < LANES; i++)
        if (has_bent_coat(v, i)) bend_coat(c, rays, i, v);
}

static void turn(struct lanes3 *v)
{
    for (int i = 0; i < LANES; i++) {
        v->x[i] = -v->x[i];
        v->y[i] = -v->y[i];
        v->z[i] = -v->z[i];
    }
}

/* The other side's origin lies as far behind the position as this side's before it. */
static void step_behind(struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        s->origin.x[i] = 2.0f * s->position.x[i] - s->origin.x[i];
        s->origin.y[i] = 2.0f * s->position.y[i] - s->origin.y[i];
        s->origin.z[i] = 2.0f * s->position.z[i] - s->origin.z[i];
    }
}

bool path_far_find(const struct path_vertex *v, struct path_vertex *far)
{
    struct lanes_mask on;
    bool any = false;
    for (int i = 0; v->any_general && i < LANES; i++) {
        const bool is = v->active.on[i] && !v->lambert.on[i] && bsdf_is_translucent(&v->bsdf[i]);
        on.on[i] = is ? -1 : 0;
        any |= is;
    }
    if (!any) return false;
    *far = *v;
    far->active = on;
    far->is_far = true;
    far->any_lambert = false;
    memset(&far->lambert, 0, sizeof far->lambert);
    memset(&far->surface.lift, 0, sizeof far->surface.lift);
    far->layers.any = false;
    far->layers.others = true;
    memset(&far->layers.on, 0, sizeof far->layers.on);
    turn(&far->surface.plane);
    turn(&far->surface.facet);
    turn(&far->surface.normal);
    step_behind(&far->surface);
    return true;
}
