#include "worker/trace/path/path.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "worker/trace/path/path_kernels.h"

static void note_camera_surface(const struct path_packet *p, const struct path_vertex *v,
                                struct path_radiance *h)
{
    const struct surface *s = &v->surface;
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t slot = p->slot[i];
        if (!s->hit.on[i]) continue;
        h->coverage[slot] = 1.0f;
        if (!v->active.on[i]) continue;
        h->albedo.r[slot] = s->albedo.x[i];
        h->albedo.g[slot] = s->albedo.y[i];
        h->albedo.b[slot] = s->albedo.z[i];
    }
}

void path_dim(struct path_rgb *color, uint32_t slot, const struct lanes3 *tint, uint32_t i)
{
    color->r[slot] *= tint->x[i];
    color->g[slot] *= tint->y[i];
    color->b[slot] *= tint->z[i];
}

/* What mirrors show is no light of theirs, but covers the pixel as they do. */
static void note_mirrors(const struct path_packet *p, const struct path_vertex *v,
                         struct path_radiance *h)
{
    const struct mirrors *m = &v->mirrors;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (m->count[i] == 0) continue;
        h->mirrored[slot] = m->count[i];
        h->coverage[slot] = 1.0f;
        path_dim(&h->albedo, slot, &m->tint, i);
    }
}

float path_ahead(const struct path_context *c, const struct path_packet *p,
                 const struct path_vertex *v, uint32_t i)
{
    const float *ahead = c->plan->camera.forward;
    const struct RTCRay16 *r = &p->rays.ray;
    const struct mirrors *m = &v->mirrors;
    float way[3] = {r->dir_x[i], r->dir_y[i], r->dir_z[i]}, distance = v->surface.distance[i];
    if (m->any && m->count[i] > 0) {
        memcpy(way, (float[]){m->way.x[i], m->way.y[i], m->way.z[i]}, sizeof way);
        distance = m->distance[i];
    }
    const float along = way[0] * ahead[0] + way[1] * ahead[1] + way[2] * ahead[2];
    const float z = distance * along;
    return z > FLT_MIN ? z : FLT_MIN; /* a hit, at 0 too */
}

/* What paths of the lens see lies this far ahead of it. */
static void note_depth(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, struct path_radiance *h)
{
    for (uint32_t i = 0; i < p->count; i++) {
        const float z = path_ahead(c, p, v, i);
        h->ahead[p->slot[i]] = v->surface.hit.on[i] ? z : INFINITY;
    }
}

/* And faces this way. */
static void note_normal(const struct path_packet *p, const struct path_vertex *v,
                        struct path_radiance *h)
{
    struct surface copy;
    const struct lanes3 *n = &mirrors_seen(v, &copy)->normal;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (!v->surface.hit.on[i]) continue;
        h->normal.r[slot] = n->x[i];
        h->normal.g[slot] = n->y[i];
        h->normal.b[slot] = n->z[i];
    }
}

/* What surfaces do to light besides scattering it diffusely, roughly. */
static void note_tint(const struct path_packet *p, const struct path_vertex *v,
                      struct path_radiance *h)
{
    for (uint32_t i = 0; v->any_general && i < p->count; i++) {
        float tint[3];
        const uint32_t slot = p->slot[i];
        if (!v->active.on[i] || v->lambert.on[i]) continue;
        bsdf_tint(&v->bsdf[i], tint);
        h->tint.r[slot] = tint[0];
        h->tint.g[slot] = tint[1];
        h->tint.b[slot] = tint[2];
        h->alpha[slot] = bsdf_sharpest_alpha(&v->bsdf[i]);
    }
}

/* What camera rays meet without a lens is so far away. */
static void note_distance(const struct path_packet *p, const struct path_vertex *v,
                          struct path_radiance *h)
{
    for (uint32_t i = 0; i < p->count; i++)
        h->distance[p->slot[i]] = v->surface.hit.on[i] ? v->surface.distance[i] : 0.0f;
}

void path_note(const struct path_context *c, const struct path_packet *p,
               const struct path_vertex *v, struct path_radiance *h)
{
    note_camera_surface(p, v, h);
    if (v->mirrors.any) note_mirrors(p, v, h);
    if (c->lens) note_depth(c, p, v, h);
    if (c->features) note_distance(p, v, h);
    if (c->features) note_tint(p, v, h);
    if (c->centres || c->features) note_normal(p, v, h);
}
