#include "worker/trace/hit/queries.h"

#include <string.h>

#include "worker/trace/hit/back_faces.h"
#include "worker/trace/hit/hit_kernels.h"

void queries_init_rays(struct RTCRayHit16 *rays)
{
    memset(rays, 0, sizeof *rays);
    memset(rays->ray.mask, 0xff, sizeof rays->ray.mask);
    for (int i = 0; i < LANES; i++) rays->ray.time[i] = SHUTTER_MIDDLE_TIME;
}

void queries_init(struct queries *q)
{
    memset(q, 0, sizeof *q);
    memset(q->narrow8.ray.mask, 0xff, sizeof q->narrow8.ray.mask);
    memset(q->narrow4.ray.mask, 0xff, sizeof q->narrow4.ray.mask);
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
    /* Measured on all three instruction sets: incoherent packets also beat single rays. */
    if (kind < QUERY_BOUNCE) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}

/* Embree 3.13.5 as Debian 12 builds it never returns from a coherent occlusion packet of sixteen
 * over instances, once its stack holds old bytes: it saves the mask of lanes still to trace in 16
 * bits (kmovw) and reads it back as 64. Other widths, closest hits and plain triangles are sound.
 * https://github.com/RenderKit/embree/pull/574 is about the same truncation. */
static struct RTCIntersectContext occlusion_context(const struct render_scene *scene,
                                                    enum query_kind kind)
{
    struct RTCIntersectContext context = context_for(kind);
    if (scene->packet_width == 16 && scene->has_instances)
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
}

void queries_sanitise(struct queries *q, struct lanes_mask *valid, const struct RTCRay16 *rays)
{
    q->rejected += q->kernels->sanitise(rays, valid);
}

/* CPUs without AVX-512 have no packets of sixteen: Embree would trace one ray after the other. They
 * get two or four narrower ones, copied in and out; fields that never change stay there. */
#define COPY_IN(field)  memcpy(part->field, whole->field + first, sizeof part->field)
#define COPY_OUT(field) memcpy(whole->field + first, part->field, sizeof part->field)

#define DEFINE_NARROW(W)                                                                           \
    static void copy_rays_##W(struct RTCRay##W *part, const struct RTCRay16 *whole, int first)     \
    {                                                                                              \
        COPY_IN(org_x), COPY_IN(org_y), COPY_IN(org_z), COPY_IN(tnear);                            \
        COPY_IN(dir_x), COPY_IN(dir_y), COPY_IN(dir_z), COPY_IN(tfar), COPY_IN(id);                \
        COPY_IN(mask), COPY_IN(time);                                                              \
    }                                                                                              \
    static void copy_hits_##W(struct RTCHit16 *whole, const struct RTCHit##W *part, int first)     \
    {                                                                                              \
        COPY_OUT(u), COPY_OUT(v), COPY_OUT(primID), COPY_OUT(geomID), COPY_OUT(instID[0]);         \
        COPY_OUT(Ng_x), COPY_OUT(Ng_y), COPY_OUT(Ng_z);                                            \
    }                                                                                              \
    static void closest_##W(const int *valid, RTCScene scene, struct RTCIntersectContext *context, \
                            struct RTCRayHit##W *part, struct RTCRayHit16 *rays)                   \
    {                                                                                              \
        for (int first = 0; first < LANES; first += (W)) {                                         \
            copy_rays_##W(&part->ray, &rays->ray, first);                                          \
            memset(part->hit.geomID, 0xff, sizeof part->hit.geomID);                               \
            memset(part->hit.instID, 0xff, sizeof part->hit.instID);                               \
            rtcIntersect##W(valid + first, scene, context, part);                                  \
            memcpy(rays->ray.tfar + first, part->ray.tfar, sizeof part->ray.tfar);                 \
            copy_hits_##W(&rays->hit, &part->hit, first);                                          \
        }                                                                                          \
    }                                                                                              \
    static void occluded_##W(const int *valid, RTCScene scene,                                     \
                             struct RTCIntersectContext *context, struct RTCRay##W *part,          \
                             struct RTCRayHit16 *rays)                                             \
    {                                                                                              \
        for (int first = 0; first < LANES; first += (W)) {                                         \
            copy_rays_##W(part, &rays->ray, first);                                                \
            rtcOccluded##W(valid + first, scene, context, part);                                   \
            memcpy(rays->ray.tfar + first, part->tfar, sizeof part->tfar);                         \
        }                                                                                          \
    }

DEFINE_NARROW(8)
DEFINE_NARROW(4)

/* Masks rays as the view asks; the caller unmasks them, since others use them after a frame. */
static void mask(const struct queries *q, enum query_kind kind, struct RTCRayHit16 *rays)
{
    if (q->view) query_view_mask(kind == QUERY_CAMERA ? q->view->camera : q->view->others, rays);
}

static void unmask(const struct queries *q, struct RTCRayHit16 *rays)
{
    if (q->view) query_view_mask(UINT32_MAX, rays);
}

/* What is hit in the ground, which stands where it is, is hit in the scene itself. */
static void leave_ground(const struct render_scene *scene, struct RTCHit16 *hit)
{
    if (scene->ground == RTC_INVALID_GEOMETRY_ID) return;
    for (int i = 0; i < LANES; i++)
        if (hit->instID[0][i] == scene->ground) hit->instID[0][i] = RTC_INVALID_GEOMETRY_ID;
}

static void intersect(struct queries *q, struct RTCIntersectContext *context,
                      const struct lanes_mask *valid, struct RTCRayHit16 *rays)
{
    if (q->scene->packet_width == 16)
        rtcIntersect16(valid->on, q->scene->top, context, rays);
    else if (q->scene->packet_width == 8)
        closest_8(valid->on, q->scene->top, context, &q->narrow8, rays);
    else
        closest_4(valid->on, q->scene->top, context, &q->narrow4, rays);
    leave_ground(q->scene, &rays->hit);
}

/* Traces the lanes that met backs once more, past all of them: few rays pay for the filter. */
static void pass_backs(struct queries *q, struct RTCIntersectContext *context,
                       const struct lanes_mask *valid, const float *reach, struct RTCRayHit16 *rays)
{
    struct lanes_mask again;
    struct RTCRayHit16 behind;
    if (!back_faces_find(q->scene, valid, rays, &again)) return;
    behind.ray = rays->ray;
    memcpy(behind.ray.tfar, reach, sizeof behind.ray.tfar);
    clear_hits(&behind.hit);
    context->filter = back_faces_filter;
    intersect(q, context, &again, &behind);
    for (int i = 0; i < LANES; i++) {
        if (!again.on[i]) continue;
        rays->ray.tfar[i] = behind.ray.tfar[i];
        rays->hit.u[i] = behind.hit.u[i];
        rays->hit.v[i] = behind.hit.v[i];
        rays->hit.primID[i] = behind.hit.primID[i];
        rays->hit.geomID[i] = behind.hit.geomID[i];
        rays->hit.instID[0][i] = behind.hit.instID[0][i];
    }
}

void queries_closest(struct queries *q, enum query_kind kind, const struct lanes_mask *valid,
                     struct RTCRayHit16 *rays)
{
    const bool culls = kind == QUERY_CAMERA && q->scene->has_culled;
    float reach[LANES];
    clear_hits(&rays->hit);
    if (q->recorder) q->recorder->record(q->recorder, kind, valid, rays);
    struct RTCIntersectContext context = context_for(kind);
    if (culls) memcpy(reach, rays->ray.tfar, sizeof reach);
    mask(q, kind, rays);
    intersect(q, &context, valid, rays);
    if (culls) pass_backs(q, &context, valid, reach, rays);
    unmask(q, rays);
    if (q->view && kind == QUERY_CAMERA) query_view_hide(q->view, q->scene, rays);
}

void queries_occluded(struct queries *q, enum query_kind kind, const struct lanes_mask *valid,
                      struct RTCRayHit16 *rays)
{
    if (q->recorder) q->recorder->record(q->recorder, kind, valid, rays);
    struct RTCIntersectContext context = occlusion_context(q->scene, kind);
    mask(q, kind, rays);
    if (q->scene->packet_width == 16)
        rtcOccluded16(valid->on, q->scene->top, &context, &rays->ray);
    else if (q->scene->packet_width == 8)
        occluded_8(valid->on, q->scene->top, &context, &q->narrow8.ray, rays);
    else
        occluded_4(valid->on, q->scene->top, &context, &q->narrow4.ray, rays);
    unmask(q, rays);
}
