#include "worker/trace/queries.h"

#include <string.h>

#include "worker/trace/lane_kernels.h"

void queries_init_rays(struct RTCRayHit16 *rays)
{
    memset(rays, 0, sizeof *rays);
    memset(rays->ray.mask, 0xff, sizeof rays->ray.mask);
}

static void clear_hits(struct RTCHit16 *hit)
{
    memset(hit->geomID, 0xff, sizeof hit->geomID);
    memset(hit->instID, 0xff, sizeof hit->instID);
}

static struct RTCIntersectContext context_for(enum query_kind kind)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (kind < QUERY_BOUNCE) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}

void queries_sanitise(struct queries *q, struct lanes_mask *valid, const struct RTCRay16 *rays)
{
    q->rejected += q->kernels->sanitise(rays, valid);
}

/* Lanes first .. first+width-1 of a field. */
#define COPY_IN(field)  memcpy(part.field, whole->field + first, sizeof part.field)
#define COPY_OUT(field) memcpy(whole->field + first, part.field, sizeof part.field)

/* CPUs without AVX-512 have no packets of sixteen: Embree would trace one ray after the other. */
#define DEFINE_NARROW(W)                                                                           \
    static void copy_rays_##W(struct RTCRay##W *to, const struct RTCRay16 *whole, int first)       \
    {                                                                                              \
        struct RTCRay##W part;                                                                     \
        COPY_IN(org_x), COPY_IN(org_y), COPY_IN(org_z), COPY_IN(tnear);                            \
        COPY_IN(dir_x), COPY_IN(dir_y), COPY_IN(dir_z), COPY_IN(time);                             \
        COPY_IN(tfar), COPY_IN(mask), COPY_IN(id), COPY_IN(flags);                                 \
        *to = part;                                                                                \
    }                                                                                              \
    static void copy_hits_##W(struct RTCHit16 *whole, const struct RTCHit##W *from, int first)     \
    {                                                                                              \
        struct RTCHit##W part = *from;                                                             \
        COPY_OUT(Ng_x), COPY_OUT(Ng_y), COPY_OUT(Ng_z), COPY_OUT(u), COPY_OUT(v);                  \
        COPY_OUT(primID), COPY_OUT(geomID), COPY_OUT(instID[0]);                                   \
    }                                                                                              \
    static void closest_##W(const int *valid, RTCScene scene, struct RTCIntersectContext *context, \
                            struct RTCRayHit16 *rays, int first)                                   \
    {                                                                                              \
        struct RTCRayHit##W part;                                                                  \
        copy_rays_##W(&part.ray, &rays->ray, first);                                               \
        memset(&part.hit, 0xff, sizeof part.hit);                                                  \
        rtcIntersect##W(valid + first, scene, context, &part);                                     \
        memcpy(rays->ray.tfar + first, part.ray.tfar, sizeof part.ray.tfar);                       \
        copy_hits_##W(&rays->hit, &part.hit, first);                                               \
    }                                                                                              \
    static void occluded_##W(const int *valid, RTCScene scene,                                     \
                             struct RTCIntersectContext *context, struct RTCRayHit16 *rays,        \
                             int first)                                                            \
    {                                                                                              \
        struct RTCRay##W part;                                                                     \
        copy_rays_##W(&part, &rays->ray, first);                                                   \
        rtcOccluded##W(valid + first, scene, context, &part);                                      \
        memcpy(rays->ray.tfar + first, part.tfar, sizeof part.tfar);                               \
    }

DEFINE_NARROW(8)
DEFINE_NARROW(4)

void queries_closest(struct queries *q, enum query_kind kind, const struct lanes_mask *valid,
                     struct RTCRayHit16 *rays)
{
    clear_hits(&rays->hit);
    if (q->recorder) q->recorder->record(q->recorder, kind, valid, rays);
    struct RTCIntersectContext context = context_for(kind);
    if (q->scene->packet_width == 16)
        rtcIntersect16(valid->on, q->scene->top, &context, rays);
    else if (q->scene->packet_width == 8)
        for (int i = 0; i < LANES; i += 8) closest_8(valid->on, q->scene->top, &context, rays, i);
    else
        for (int i = 0; i < LANES; i += 4) closest_4(valid->on, q->scene->top, &context, rays, i);
}

void queries_occluded(struct queries *q, enum query_kind kind, const struct lanes_mask *valid,
                      struct RTCRayHit16 *rays)
{
    if (q->recorder) q->recorder->record(q->recorder, kind, valid, rays);
    struct RTCIntersectContext context = context_for(kind);
    if (q->scene->packet_width == 16)
        rtcOccluded16(valid->on, q->scene->top, &context, &rays->ray);
    else if (q->scene->packet_width == 8)
        for (int i = 0; i < LANES; i += 8) occluded_8(valid->on, q->scene->top, &context, rays, i);
    else
        for (int i = 0; i < LANES; i += 4) occluded_4(valid->on, q->scene->top, &context, rays, i);
}
