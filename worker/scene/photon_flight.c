#include "worker/scene/photon_flight.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/mesh.h"
#include "worker/shade/direction.h"
#include "worker/shade/fresnel.h"

/* The most surfaces that bend a photon. */
#define BENDS 8u

/* Surfaces up to this roughness send photons on in one direction. */
#define SMOOTH_ROUGHNESS 0.2f

/* Glass that transmits less is as good as opaque. */
#define CLEAR_MIN 0.5f

/* Photons of which less is left are lost. */
#define POWER_MIN 1e-3f

/* Glass of an index this near to that of air bends nothing. */
#define BENT_MIN 0.01f

static bool is_lens(const struct material *m)
{
    return m->transmission >= CLEAR_MIN && m->volume && m->roughness <= SMOOTH_ROUGHNESS &&
           fabsf(m->ior - 1.0f) > BENT_MIN;
}

static bool is_mirror(const struct material *m)
{
    return !m->transmissive && m->metallic > 0.5f && m->roughness <= SMOOTH_ROUGHNESS &&
           !m->metallic_roughness_texture.texels;
}

bool photon_flight_is_bent_by(const struct material *m)
{
    return !m->emissive && !m->unlit && !m->blend && (is_lens(m) || is_mirror(m));
}

struct meeting {
    const struct mesh_view *mesh;
    float at[3], normal[3]; /* of the surface, unit, on the side that the winding faces */
    uint32_t instance;
};

/* The cofactors of the transform turn normals. */
static void turn_normal(const float m[12], const float n[3], float out[3])
{
    const float *x = m, *y = m + 4, *z = m + 8;
    float c[3];
    const float det = x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) +
                      x[2] * (y[0] * z[1] - y[1] * z[0]);
    const float sign = det < 0.0f ? -1.0f : 1.0f;
    for (int k = 0; k < 3; k++) {
        const float *a = m + (ptrdiff_t)4 * ((k + 1) % 3), *b = m + (ptrdiff_t)4 * ((k + 2) % 3);
        c[k] = sign * ((a[1] * b[2] - a[2] * b[1]) * n[0] + (a[2] * b[0] - a[0] * b[2]) * n[1] +
                       (a[0] * b[1] - a[1] * b[0]) * n[2]);
    }
    direction_normalize(c[0], c[1], c[2], out);
}

/* Returns the number of the instance that was met. */
static uint32_t find_normal(const struct render_scene *scene, const struct RTCHit *hit,
                            struct meeting *m)
{
    const bool placed =
        hit->instID[0] != RTC_INVALID_GEOMETRY_ID && hit->instID[0] != scene->ground;
    const uint32_t index = placed ? hit->instID[0] : hit->geomID;
    const struct scene_instance *instance = &scene->blob->instances[index];
    float n[3] = {hit->Ng_x, hit->Ng_y, hit->Ng_z};
    m->mesh = &scene->meshes[instance->mesh];
    const struct mesh_point p = mesh_point_at(m->mesh, hit->primID, hit->u, hit->v);
    for (size_t k = 0; m->mesh->normals && k < 3; k++)
        n[k] = mesh_interpolate(&p, m->mesh->normals, 3, k);
    turn_normal(instance->to_world, n, m->normal);
    return index;
}

static bool meet(const struct render_scene *scene, const struct photon_flight *f, struct meeting *m)
{
    struct RTCIntersectContext context;
    struct RTCRayHit r = {.ray = {.org_x = f->at[0],
                                  .org_y = f->at[1],
                                  .org_z = f->at[2],
                                  .dir_x = f->way[0],
                                  .dir_y = f->way[1],
                                  .dir_z = f->way[2],
                                  .tnear = f->near,
                                  .tfar = INFINITY,
                                  .time = 0.5f,
                                  .mask = UINT32_MAX}};
    for (int k = 0; k < 3; k++)
        if (!(fabsf(f->at[k]) < 1e18f) || !(fabsf(f->way[k]) <= 1.001f)) return false;
    rtcInitIntersectContext(&context);
    r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene->top, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    m->instance = find_normal(scene, &r.hit, m);
    for (int k = 0; k < 3; k++) m->at[k] = f->at[k] + r.ray.tfar * f->way[k];
    return true;
}

static float luminance(const float c[4])
{
    return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

/* Turns a photon where it meets a lens or a mirror; at a lens by chance, as much as that reflects.
 */
static void bend(const struct meeting *m, uint32_t *random, struct photon_flight *f)
{
    const struct material *of = m->mesh->material;
    const float back[3] = {-f->way[0], -f->way[1], -f->way[2]};
    const float along = direction_dot(back, m->normal);
    const bool behind = along < 0.0f;
    const float cosine = fminf(fabsf(along), 1.0f);
    float n[3], far, out[3];
    for (int k = 0; k < 3; k++) n[k] = behind ? -m->normal[k] : m->normal[k];
    const float eta = behind ? 1.0f / of->ior : of->ior;
    const bool mirror = is_mirror(of);
    if (mirror || path_next(random) < fresnel_dielectric(cosine, eta, &far)) {
        direction_reflect(back, n, cosine, out);
        if (mirror) f->power *= luminance(of->base_color);
    } else {
        direction_refract(back, n, cosine, far, eta, out);
        f->power *= of->transmission * luminance(of->base_color);
    }
    memcpy(f->way, out, sizeof out);
    memcpy(f->at, m->at, sizeof m->at);
}

static bool is_finite(const float v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

bool photon_flight_follow(const struct render_scene *scene, struct photon_flight *f,
                          float clearance, uint32_t *random, struct photon *out)
{
    const float least = POWER_MIN * f->power;
    struct meeting m;
    uint32_t bent = 0;
    for (;; bent++, f->near = clearance) {
        if (!meet(scene, f, &m) || !(f->power > least)) return false;
        if (!photon_flight_is_bent_by(m.mesh->material)) break;
        if (bent == BENDS || (bent == 0 && m.instance != f->to)) return false;
        bend(&m, random, f);
    }
    if (bent == 0 || m.mesh->material->emissive || m.mesh->material->transmissive) return false;
    out->power = f->power;
    memcpy(out->place, m.at, sizeof out->place);
    memcpy(out->from, f->at, sizeof out->from);
    return is_finite(out->place) && is_finite(out->from);
}
