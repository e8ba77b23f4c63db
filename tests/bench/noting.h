#pragma once
/* Any-hit rays that note which blocker they met, for benchmarks: a scene that calls filter
 * functions and one that writes distances down. */
#include <embree3/rtcore.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/scene/scene.h"

/* Of a packet whose rays' ids are their lanes. */
struct noting_context {
    struct RTCIntersectContext base;
    float distance[16];
};

/* Embree hands on packets of any width: arrays one after the other, tfar the ninth of a ray's, its
 * id the eleventh. */
static void note(const struct RTCFilterFunctionNArguments *args)
{
    struct noting_context *context = (struct noting_context *)args->context;
    const float *tfar = (const float *)args->ray + (size_t)8 * args->N;
    const uint32_t *id = (const uint32_t *)args->ray + (size_t)10 * args->N;
    for (unsigned int i = 0; i < args->N; i++)
        if (args->valid[i] == -1) context->distance[id[i] & 15u] = tfar[i];
}

/* Coherent rays. */
static inline void noting_init(struct noting_context *context, bool notes)
{
    rtcInitIntersectContext(&context->base);
    context->base.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    if (notes) context->base.filter = note;
    for (int i = 0; i < 16; i++) context->distance[i] = 0.0f;
}

/* All placed meshes once more, in a scene that calls filters. NULL when it has instances. */
static inline RTCScene noting_scene(const struct scene *blob, RTCDevice device)
{
    for (uint64_t i = 0; i < blob->count[SCENE_INSTANCES]; i++)
        if (!(blob->instances[i].flags & INSTANCE_IDENTITY)) return NULL;
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    for (uint64_t i = 0; i < blob->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *mesh = &blob->meshes[blob->instances[i].mesh];
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   blob->positions + (size_t)3 * mesh->first_vertex, 0,
                                   3 * sizeof(float), mesh->vertex_count);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   blob->triangles + (size_t)3 * mesh->first_triangle, 0,
                                   3 * sizeof(uint32_t), mesh->triangle_count);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);
    return scene;
}
