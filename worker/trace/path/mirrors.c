#include "worker/trace/path/mirrors.h"

#include <math.h>
#include <string.h>

#include "worker/trace/path/path.h"
#include "worker/trace/path/path_record.h"

/* The least cosine between a flat triangle's normal and those of its corners, of 0.08 degrees. */
#define FLAT_COSINE 0.999999f

/* The least side of a square as large as a flat triangle, in pixels at its distance. A smaller one
 * is part of a shape that may be as bent as its triangles are small. */
#define FLAT_SIDE_PX 4.0f

/* Returns whether the material may mirror. One that shines is met as it is, since its emission is
 * not in the image behind it. */
static bool may_mirror(const struct material *m)
{
    if (m->emissive) return false;
    if (m->model == MODEL_MIRROR) return !m->normal_texture.texels;
    return m->model == MODEL_GLTF && !m->unlit && m->metallic >= 1.0f && !(m->coat > 0.0f) &&
           !m->has_sheen && m->roughness * m->roughness < BSDF_SMOOTH &&
           !m->metallic_roughness_texture.texels && !m->normal_texture.texels;
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Returns whether the corners' normals are the triangle's unit normal n, in the mesh's space. */
static bool is_smooth(const struct mesh_view *mesh, const uint32_t *corners, const float n[3])
{
    for (int k = 0; mesh->normals && k < 3; k++) {
        const float *own = mesh->normals + (size_t)3 * corners[k];
        const float square = dot(own, own), along = dot(own, n);
        if (!(along * along >= FLAT_COSINE * FLAT_COSINE * square)) return false;
    }
    return true;
}

/* Returns by how much lengths grow in the world, at least. */
static float scale_of(const struct path_context *c, const struct RTCHit16 *hit, int i)
{
    const uint32_t placed = hit->instID[0][i];
    if (placed == RTC_INVALID_GEOMETRY_ID) return 1.0f;
    const float *m = c->queries->scene->blob->instances[placed].to_world;
    float least = INFINITY;
    for (int k = 0; k < 3; k++) {
        const float square = m[k] * m[k] + m[4 + k] * m[4 + k] + m[8 + k] * m[8 + k];
        least = fminf(least, square);
    }
    return sqrtf(least);
}

static bool is_flat(const struct path_context *c, const struct RTCHit16 *hit,
                    const struct mesh_view *mesh, int i, float distance)
{
    const uint32_t *corners = mesh->triangles + (size_t)3 * hit->primID[i];
    const float *at = mesh->positions + (size_t)3 * corners[0];
    float side[2][3], n[3];
    for (int k = 0; k < 2; k++)
        for (size_t j = 0; j < 3; j++)
            side[k][j] = mesh->positions[(size_t)3 * corners[k + 1] + j] - at[j];
    cross(side[0], side[1], n);
    const float twice = sqrtf(dot(n, n));
    if (!(twice > 0.0f)) return false;
    for (int j = 0; j < 3; j++) n[j] /= twice;
    const float square = scale_of(c, hit, i) * sqrtf(0.5f * twice);
    return square >= FLAT_SIDE_PX * plan_pixel_size(c->plan, distance) &&
           is_smooth(mesh, corners, n);
}

/* Finds the lanes whose surface is a flat mirror that may be followed. Returns whether there is
 * any. */
static bool find(const struct path_context *c, const struct RTCRayHit16 *rays,
                 const struct path_vertex *v, uint32_t seen, struct lanes_mask *out)
{
    const struct surface *s = &v->surface;
    const struct mirrors *m = &v->mirrors;
    bool any = false;
    for (int i = 0; i < LANES; i++) {
        out->on[i] = 0;
        if (!s->hit.on[i] || !may_mirror(s->mesh[i]->material)) continue;
        if (seen > 0 && m->count[i] != seen) continue; /* no mirror, when it was met before */
        const float before = seen > 0 ? m->distance[i] : 0.0f;
        if (!is_flat(c, &rays->hit, s->mesh[i], i, before + s->distance[i])) continue;
        out->on[i] = -1;
        any = true;
    }
    return any;
}

static void begin(const struct RTCRayHit16 *rays, const struct path_vertex *v, struct mirrors *m)
{
    const struct RTCRay16 *r = &rays->ray;
    m->any = true;
    memset(m->count, 0, sizeof m->count);
    memcpy(m->eye.x, r->org_x, sizeof m->eye.x);
    memcpy(m->eye.y, r->org_y, sizeof m->eye.y);
    memcpy(m->eye.z, r->org_z, sizeof m->eye.z);
    memcpy(m->way.x, r->dir_x, sizeof m->way.x);
    memcpy(m->way.y, r->dir_y, sizeof m->way.y);
    memcpy(m->way.z, r->dir_z, sizeof m->way.z);
    memcpy(m->distance, v->surface.distance, sizeof m->distance);
    for (int i = 0; i < LANES; i++) m->tint.x[i] = m->tint.y[i] = m->tint.z[i] = 1.0f;
}

/* Reflects the ray of a lane. Returns false if nothing comes of it. */
static bool reflect(const struct path_vertex *v, int i, struct path_record_scatter *out)
{
    static const float middle[2] = {0.5f, 0.5f};
    const struct surface *s = &v->surface;
    const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]};
    struct bsdf_sample sample;
    if (!bsdf_sample(&v->bsdf[i], wo, 0.5f, middle, &sample)) return false;
    if (!sample.dirac || sample.transmitted) return false;
    float d[3];
    path_from_frame(v, i, sample.wi, d);
    const float above = d[0] * s->facet.x[i] + d[1] * s->facet.y[i] + d[2] * s->facet.z[i];
    *out = (struct path_record_scatter){.on = true, .dirac = true, .goes_on = true};
    memcpy(out->direction, d, sizeof d);
    memcpy(out->weight, sample.specular, sizeof out->weight);
    return above > 0.0f;
}

static void aim(const struct surface *s, int i, const float d[3], struct RTCRay16 *r)
{
    const struct vector start = surface_start(s, i, d[0], d[1], d[2]);
    r->org_x[i] = start.x;
    r->org_y[i] = start.y;
    r->org_z[i] = start.z;
    r->dir_x[i] = d[0];
    r->dir_y[i] = d[1];
    r->dir_z[i] = d[2];
    r->tnear[i] = 0.0f;
    r->tfar[i] = INFINITY;
}

/* Notes reflection number `seen` of lane i. */
static void note(const struct surface *s, uint32_t seen, int i, const float weight[3],
                 struct mirrors *m, struct path_packet *p)
{
    m->count[i] = seen + 1;
    m->normal[seen].x[i] = s->normal.x[i];
    m->normal[seen].y[i] = s->normal.y[i];
    m->normal[seen].z[i] = s->normal.z[i];
    m->tint.x[i] *= weight[0];
    m->tint.y[i] *= weight[1];
    m->tint.z[i] *= weight[2];
    if (!p) return;
    p->throughput.x[i] *= weight[0];
    p->throughput.y[i] *= weight[1];
    p->throughput.z[i] *= weight[2];
}

/* Records the only path's reflection. */
PATH_RECORD_COLD static void record(const struct path_context *c, const struct path_packet *p,
                                    const struct path_vertex *v,
                                    const struct path_record_scatter *to)
{
    path_record_arrive(c, p, v);
    path_record_surface(c, v);
    path_record_scatter(c, p, v, to);
}

/* Reflects the lanes of *on. Those that cannot be reflected leave it. */
static void turn(const struct path_context *c, struct path_packet *p, uint32_t seen,
                 struct path_vertex *v, struct lanes_mask *on, struct RTCRayHit16 *next)
{
    for (int i = 0; i < LANES; i++) {
        struct path_record_scatter to;
        if (!on->on[i]) continue;
        if (!reflect(v, i, &to)) {
            on->on[i] = 0;
            continue;
        }
        if (c->record && p) record(c, p, v, &to);
        aim(&v->surface, i, to.direction, &next->ray);
        note(&v->surface, seen, i, to.weight, &v->mirrors, p);
    }
}

/* Takes over the rays and hits of the lanes of *on, which have come back. */
static void join(const struct lanes_mask *on, const struct RTCRayHit16 *next,
                 struct RTCRayHit16 *rays, struct mirrors *m)
{
    for (int i = 0; i < LANES; i++) {
        const struct RTCRay16 *r = &next->ray;
        if (!on->on[i]) continue;
        const bool met = next->hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        rays->ray.org_x[i] = r->org_x[i];
        rays->ray.org_y[i] = r->org_y[i];
        rays->ray.org_z[i] = r->org_z[i];
        rays->ray.dir_x[i] = r->dir_x[i];
        rays->ray.dir_y[i] = r->dir_y[i];
        rays->ray.dir_z[i] = r->dir_z[i];
        rays->ray.tnear[i] = r->tnear[i];
        rays->ray.tfar[i] = r->tfar[i];
        rays->hit.u[i] = next->hit.u[i];
        rays->hit.v[i] = next->hit.v[i];
        rays->hit.primID[i] = next->hit.primID[i];
        rays->hit.geomID[i] = next->hit.geomID[i];
        rays->hit.instID[0][i] = next->hit.instID[0][i];
        m->distance[i] += met ? r->tfar[i] : INFINITY;
    }
}

void mirrors_follow(const struct path_context *c, struct path_packet *p, struct RTCRayHit16 *rays,
                    struct path_vertex *v)
{
    struct mirrors *m = &v->mirrors;
    struct lanes_mask on, all;
    m->any = false;
    for (int i = 0; i < LANES; i++) all.on[i] = -1;
    for (uint32_t seen = 0; seen < c->plan->lens_mirrors && find(c, rays, v, seen, &on); seen++) {
        struct RTCRayHit16 next;
        if (seen == 0) begin(rays, v, m);
        queries_init_rays(&next);
        v->active = on;
        path_resolve(c, rays, v);
        turn(c, p, seen, v, &on, &next);
        struct lanes_mask valid = on;
        queries_sanitise(c->queries, &valid, &next.ray);
        c->counters->value[COUNTER_RAYS_LENS_MIRRORS] += lanes_count(&valid);
        queries_closest(c->queries, QUERY_BOUNCE, &valid, &next);
        join(&on, &next, rays, m);
        hit_resolve(c->queries, &all, rays, &v->surface);
    }
}

void mirrors_image(const struct path_vertex *v, int i, float point[3], float normal[3])
{
    const struct surface *s = &v->surface;
    const struct mirrors *m = &v->mirrors;
    const float n[3] = {s->normal.x[i], s->normal.y[i], s->normal.z[i]};
    const float at[3] = {s->position.x[i], s->position.y[i], s->position.z[i]};
    memcpy(normal, n, sizeof n);
    memcpy(point, at, sizeof at);
    if (!m->any || m->count[i] == 0) return;
    const float t = m->distance[i];
    point[0] = m->eye.x[i] + t * m->way.x[i];
    point[1] = m->eye.y[i] + t * m->way.y[i];
    point[2] = m->eye.z[i] + t * m->way.z[i];
    for (uint32_t k = m->count[i]; k-- > 0;) {
        const float by[3] = {m->normal[k].x[i], m->normal[k].y[i], m->normal[k].z[i]};
        const float twice = 2.0f * dot(normal, by);
        for (int j = 0; j < 3; j++) normal[j] -= twice * by[j];
    }
}

const struct surface *mirrors_seen(const struct path_vertex *v, struct surface *copy)
{
    const struct mirrors *m = &v->mirrors;
    if (!m->any) return &v->surface;
    *copy = v->surface;
    for (int i = 0; i < LANES; i++) {
        float point[3], normal[3];
        if (!copy->hit.on[i] || m->count[i] == 0) continue;
        mirrors_image(v, i, point, normal);
        copy->distance[i] = m->distance[i];
        copy->normal.x[i] = normal[0];
        copy->normal.y[i] = normal[1];
        copy->normal.z[i] = normal[2];
    }
    return copy;
}
