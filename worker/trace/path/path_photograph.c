#include "worker/trace/path/path_photograph.h"

#include <math.h>
#include <string.h>

#include "worker/trace/path/chains.h"

/* Points that the camera sees at a smaller cosine are seen too coarsely. */
#define FACING_MIN 0.02f

/* Where the photograph shows what sixteen paths meet. */
struct shown_points {
    struct lanes_mask on;
    float px[LANES], py[LANES];
};

/* Mirrors and what shines or has a volume look otherwise from elsewhere. */
static bool looks_alike(const struct path_vertex *v, int i)
{
    const struct surface *s = &v->surface;
    const struct bsdf *b = &v->bsdf[i];
    if (s->light.on[i] || s->emission.x[i] + s->emission.y[i] + s->emission.z[i] > 0.0f)
        return false;
    if (v->lambert.on[i]) return true;
    return !s->mesh[i]->material->volume && !bsdf_is_dirac(b) &&
           b->albedo[0] + b->albedo[1] + b->albedo[2] > 0.0f;
}

static bool is_real(const struct path_context *c, uint32_t id)
{
    return instance_class(&c->queries->scene->blob->instances[id - 1]) != INSTANCE_IS_VIRTUAL;
}

/* Aims a ray at the camera from lane i's point. False: the camera does not see that side, or no
 * such point. */
static bool aim(const struct path_context *c, const struct path_vertex *v, int i,
                struct shown_points *out, struct RTCRay16 *r)
{
    const struct surface *s = &v->surface;
    const float at[3] = {s->position.x[i], s->position.y[i], s->position.z[i]};
    float to[3], distance;
    if (!photograph_find(c->photograph, at, to, &distance, &out->px[i], &out->py[i])) return false;
    const float facing = to[0] * s->plane.x[i] + to[1] * s->plane.y[i] + to[2] * s->plane.z[i];
    const struct vector start = surface_start(s, i, to[0], to[1], to[2]);
    r->org_x[i] = start.x, r->org_y[i] = start.y, r->org_z[i] = start.z;
    r->dir_x[i] = to[0], r->dir_y[i] = to[1], r->dir_z[i] = to[2];
    r->tnear[i] = 0.0f;
    r->tfar[i] = distance;
    return facing > FACING_MIN;
}

/* Leaves the points that something real hides from the camera. */
static void drop_hidden(const struct path_context *c, const struct path_packet *p,
                        struct RTCRayHit16 *rays, struct lanes_mask *on)
{
    memcpy(rays->ray.time, p->rays.ray.time, sizeof rays->ray.time);
    queries_sanitise(c->queries, on, &rays->ray);
    c->counters->value[COUNTER_RAYS_INDIRECT_SHADOW] += lanes_count(on);
    queries_occluded(c->queries, QUERY_BOUNCE_SHADOW, on, rays);
    for (int i = 0; i < LANES; i++)
        if (on->on[i] && rays->ray.tfar[i] < 0.0f) on->on[i] = 0;
}

/* A lookup in the photograph reads so many pixels to each side. */
#define AROUND_PX 1.5f

/* What lies so far from the point's plane, over its distance from the point, is another surface. */
#define OFF_PLANE 0.5f

/* Returns whether a ray of the camera has met what the point is a part of, and nothing that shines.
 */
static bool is_alike(const struct path_context *c, const struct path_vertex *v, int i,
                     const struct RTCRayHit16 *rays)
{
    const struct surface *s = &v->surface;
    const struct RTCRay16 *r = &rays->ray;
    const struct render_scene *scene = c->queries->scene;
    if (rays->hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) return false;
    const uint32_t placed = rays->hit.instID[0][i];
    const uint32_t index = placed != RTC_INVALID_GEOMETRY_ID ? placed : rays->hit.geomID[i];
    if (scene->meshes[scene->blob->instances[index].mesh].traits & MESH_SHINES) return false;
    const float d[3] = {r->org_x[i] + r->tfar[i] * r->dir_x[i] - s->position.x[i],
                        r->org_y[i] + r->tfar[i] * r->dir_y[i] - s->position.y[i],
                        r->org_z[i] + r->tfar[i] * r->dir_z[i] - s->position.z[i]};
    const float off = d[0] * s->plane.x[i] + d[1] * s->plane.y[i] + d[2] * s->plane.z[i];
    return off * off <= OFF_PLANE * OFF_PLANE * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* Leaves the points beside which pixels show something else, too, such as a lamp. */
static void drop_mixed(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, struct RTCRayHit16 *rays,
                       struct shown_points *out)
{
    struct RTCRay16 *r = &rays->ray;
    for (int k = 0; k < 4; k++) {
        const float x = k & 1 ? AROUND_PX : -AROUND_PX, y = k & 2 ? AROUND_PX : -AROUND_PX;
        for (int i = 0; i < LANES; i++) {
            float from[3], way[3];
            if (!out->on.on[i]) continue;
            plan_camera_ray(c->plan, out->px[i] + x, out->py[i] + y, from, way);
            r->org_x[i] = from[0], r->org_y[i] = from[1], r->org_z[i] = from[2];
            r->dir_x[i] = way[0], r->dir_y[i] = way[1], r->dir_z[i] = way[2];
            r->tnear[i] = 0.0f;
            r->tfar[i] = INFINITY;
        }
        memcpy(r->time, p->rays.ray.time, sizeof r->time);
        queries_sanitise(c->queries, &out->on, r);
        c->counters->value[COUNTER_RAYS_INDIRECT_SHADOW] += lanes_count(&out->on);
        queries_closest(c->queries, QUERY_BOUNCE, &out->on, rays);
        for (int i = 0; i < LANES; i++)
            if (out->on.on[i] && !is_alike(c, v, i, rays)) out->on.on[i] = 0;
    }
}

/* Finds the points among what paths meet that have just left objects. The camera looks through
 * objects, as the one that took the photograph did. */
static uint32_t find(const struct path_context *c, const struct path_packet *p,
                     const struct path_vertex *v, struct RTCRayHit16 *rays,
                     struct shown_points *out)
{
    const struct query_view *view = c->queries->view;
    memset(&out->on, 0, sizeof out->on);
    for (int i = 0; i < (int)p->count; i++)
        if (p->from_object[i] && p->part[i] == PATH_PART_NONE && v->active.on[i] &&
            is_real(c, v->surface.id[i]) && looks_alike(v, i) && aim(c, v, i, out, &rays->ray))
            out->on.on[i] = -1;
    if (lanes_count(&out->on) == 0) return 0;
    if (c->blended) memset(rays->ray.id, 0, sizeof rays->ray.id);
    c->queries->view = query_view_of(PLAN_VIEW_WITHOUT);
    drop_hidden(c, p, rays, &out->on);
    if (lanes_count(&out->on) > 0) drop_mixed(c, p, v, rays, out);
    c->queries->view = view;
    return lanes_count(&out->on);
}

/* Notes what lane i's path brings but for the ratio. */
static void note(const struct path_context *c, const struct path_packet *p,
                 const struct path_vertex *v, uint32_t i, const struct shown_points *points,
                 struct path_radiance *h)
{
    float color[3];
    struct path_shown *shown = &h->shown;
    const uint32_t slot = p->slot[i];
    photograph_read(c->photograph, points->px[i], points->py[i], color);
    shown->throughput.r[slot] = p->throughput.x[i];
    shown->throughput.g[slot] = p->throughput.y[i];
    shown->throughput.b[slot] = p->throughput.z[i];
    shown->light.r[slot] = p->throughput.x[i] * color[0];
    shown->light.g[slot] = p->throughput.y[i] * color[1];
    shown->light.b[slot] = p->throughput.z[i] * color[2];
    shown->depth[slot] = (uint8_t)v->depth;
    shown->ends_chain[slot] = chains_has(c, p, v, h, i);
}

/* Begins the path `without` at the segment that the packet's lane has come by. */
static void begin_real(const struct path_packet *p, uint32_t i, struct path_pool *real)
{
    uint32_t lane;
    struct path_packet *to = path_pool_add(real, &lane);
    const struct RTCRay16 *from = &p->rays.ray;
    struct RTCRay16 *r = &to->rays.ray;
    r->org_x[lane] = from->org_x[i], r->org_y[lane] = from->org_y[i];
    r->org_z[lane] = from->org_z[i];
    r->dir_x[lane] = from->dir_x[i], r->dir_y[lane] = from->dir_y[i];
    r->dir_z[lane] = from->dir_z[i];
    r->tnear[lane] = 0.0f;
    r->tfar[lane] = INFINITY;
    r->time[lane] = from->time[i];
    to->throughput.x[lane] = to->throughput.y[lane] = to->throughput.z[lane] = 1.0f;
    to->pdf[lane] = to->sky_share[lane] = to->lights[lane] = 0.0f;
    to->promise[lane] = 1.0f;
    to->sky_table[lane] = 0;
    to->from.x[lane] = p->from.x[i], to->from.y[lane] = p->from.y[i];
    to->from.z[lane] = p->from.z[i];
    to->normal.x[lane] = p->normal.x[i], to->normal.y[lane] = p->normal.y[i];
    to->normal.z[lane] = p->normal.z[i];
    to->key[lane] = p->key[i];
    to->sample[lane] = p->sample[i];
    to->slot[lane] = p->slot[i];
    to->colored[lane] = p->colored[i];
    to->part[lane] = PATH_PART_ARRIVING;
    to->from_object[lane] = 0;
}

void path_photograph_meet(const struct path_context *c, struct path_packet *p,
                          const struct path_vertex *v, struct path_scratch *s,
                          struct path_pool *real)
{
    struct shown_points points;
    if (find(c, p, v, &s->occlusion, &points) == 0) return;
    for (uint32_t i = 0; i < p->count; i++) {
        if (!points.on.on[i]) continue;
        note(c, p, v, i, &points, &s->radiance);
        begin_real(p, i, real);
        p->part[i] = PATH_PART_WITH;
        p->throughput.x[i] = p->throughput.y[i] = p->throughput.z[i] = 1.0f;
    }
}

void path_part_add_lanes(const struct path_packet *p, struct lanes_mask *on,
                         const struct lanes3 *value, struct path_radiance *h)
{
    for (uint32_t i = 0; i < p->count; i++) {
        if (!on->on[i] || p->part[i] == PATH_PART_NONE) continue;
        path_part_add(h, (enum path_part)p->part[i], p->slot[i],
                      (float[]){value->x[i], value->y[i], value->z[i]});
        on->on[i] = 0;
    }
}

/* Sums over samples of one pixel, in one colour. */
struct shown_sums {
    double light, kept,
        without;            /* throughput * photograph, the less of with and without, without */
    double product, square; /* kept * without, without^2 */
};

/* What objects do to the photograph's light in one colour. */
struct shown_change {
    float kept; /* share of it that they leave */
    float gain; /* of what they add, the photograph's light over that of the scene */
};

static void sum(float light, float throughput, float with, float without, struct shown_sums *sums)
{
    const double a = (double)(throughput * fminf(with, without));
    const double b = (double)(throughput * without);
    sums->light += (double)light;
    sums->kept += a;
    sums->without += b;
    sums->product += a * b;
    sums->square += b * b;
}

static bool is_finite(const struct path_rgb *of, uint32_t slot)
{
    return of->r[slot] < INFINITY && of->g[slot] < INFINITY && of->b[slot] < INFINITY;
}

static void sum_slot(const struct path_shown *shown, uint32_t slot, struct shown_sums sums[3])
{
    const struct path_rgb *l = &shown->light, *t = &shown->throughput;
    const struct path_rgb *a = &shown->with, *b = &shown->without;
    if (shown->depth[slot] == 0 || !is_finite(l, slot) || !is_finite(t, slot) ||
        !is_finite(a, slot) || !is_finite(b, slot))
        return; /* such a sample is rejected, alone */
    sum(l->r[slot], t->r[slot], a->r[slot], b->r[slot], &sums[0]);
    sum(l->g[slot], t->g[slot], a->g[slot], b->g[slot], &sums[1]);
    sum(l->b[slot], t->b[slot], a->b[slot], b->b[slot], &sums[2]);
}

/* The ratio of the means of n samples is put right by what it is off because the divisor is noisy
 * (Beale 1962; the rest falls with n^2). Where no path brings light, as where light samples were
 * behind something real, nothing tells that an object changes it. The gain is the photograph's
 * light over the mean of that and the scene's: where few samples brought hardly any light, what
 * objects add would burn out. */
static struct shown_change change_of(const struct shown_sums *s, double n)
{
    struct shown_change out = {.kept = 1.0f, .gain = 1.0f};
    if (!(s->without > 0)) return out;
    if (s->light > 0) out.gain = (float)(2 * s->light / (s->light + s->without));
    if (s->kept == s->without) return out;
    double over = s->kept, under = s->without;
    if (n > 1) {
        const double both = s->kept * s->without, squared = s->without * s->without;
        over = both + (n * s->product - both) / (n - 1);
        under = squared + (n * s->square - squared) / (n - 1);
    }
    if (over < under) out.kept = (float)(over / under);
    return out;
}

static float over(float light, float albedo)
{
    return albedo > 0.0f ? light / albedo : 0.0f;
}

static float change(float light, float throughput, float with, float without,
                    const struct shown_change *by)
{
    return light * by->kept + by->gain * throughput * fmaxf(with - without, 0.0f);
}

/* After a chain of mirrors all of it is diffuse light of what they show. */
static void add_slot(const struct path_context *c, uint32_t slot, const struct shown_change by[3],
                     struct path_radiance *h)
{
    const struct path_shown *shown = &h->shown;
    const struct path_rgb *l = &shown->light, *t = &shown->throughput;
    const struct path_rgb *a = &shown->with, *b = &shown->without;
    if (shown->depth[slot] == 0) return;
    const float light[3] = {change(l->r[slot], t->r[slot], a->r[slot], b->r[slot], &by[0]),
                            change(l->g[slot], t->g[slot], a->g[slot], b->g[slot], &by[1]),
                            change(l->b[slot], t->b[slot], a->b[slot], b->b[slot], &by[2])};
    if (shown->ends_chain[slot]) {
        h->diffuse_direct.r[slot] += over(light[0], h->albedo.r[slot]);
        h->diffuse_direct.g[slot] += over(light[1], h->albedo.g[slot]);
        h->diffuse_direct.b[slot] += over(light[2], h->albedo.b[slot]);
        h->share.r[slot] = h->share.g[slot] = h->share.b[slot] = 0.0f;
    }
    path_radiance_add(c, h, shown->depth[slot] + 1u, slot, light);
}

/* Halves of parts, and what is in none. */
enum { GROUPS = 3 };

static int group_of(const struct plan_split *parts, uint32_t sample)
{
    if (sample < parts->first || sample >= parts->first + parts->length * parts->count) return 2;
    return (sample - parts->first) % parts->length < parts->length / 2 ? 0 : 1;
}

/* The samples of a pixel that group[] has in group g. */
static void add_samples(const struct path_context *c, uint32_t lane, const int group[PATH_SAMPLES],
                        int g, uint32_t count, struct path_radiance *h)
{
    struct shown_sums sums[3] = {{0}};
    struct shown_change by[3];
    double n = 0;
    for (uint32_t k = 0; k < count; k++) {
        if (group[k] != g) continue;
        sum_slot(&h->shown, k * LANES + lane, sums);
        n++;
    }
    if (n == 0) return;
    for (int k = 0; k < 3; k++) by[k] = change_of(&sums[k], n);
    for (uint32_t k = 0; k < count; k++)
        if (group[k] == g) add_slot(c, k * LANES + lane, by, h);
}

void path_photograph_add(const struct path_context *c, const struct plan_split *parts,
                         uint32_t first, uint32_t count, struct path_radiance *h)
{
    int group[PATH_SAMPLES];
    for (uint32_t k = 0; k < count; k++) group[k] = group_of(parts, first + k);
    for (uint32_t lane = 0; lane < LANES; lane++)
        for (int g = 0; g < GROUPS; g++) add_samples(c, lane, group, g, count, h);
}
