#include "worker/scene/render_scene.h"

#include <embree3/rtcore.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/build.h"
#include "worker/scene/alpha.h"
#include "worker/scene/caustics.h"
#include "worker/scene/emitters.h"
#include "worker/scene/lobe_boxes.h"
#include "worker/scene/mesh.h"
#include "worker/scene/movers.h"
#include "worker/scene/photon_targets.h"
#include "worker/scene/sky_guide.h"

static char version_text[32];
static pthread_once_t version_once = PTHREAD_ONCE_INIT;

static void version_read(void)
{
    RTCDevice device = rtcNewDevice("threads=1");
    if (!device) return;
    snprintf(version_text, sizeof version_text, "%ld.%ld.%ld",
             (long)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MAJOR),
             (long)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MINOR),
             (long)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_PATCH));
    rtcReleaseDevice(device);
}

const char *render_embree_version(void)
{
    pthread_once(&version_once, version_read);
    return version_text[0] ? version_text : NULL;
}

static bool is_base(const struct render_scene *s)
{
    return s->blob->info->flags & SCENE_IS_BASE;
}

static void step(_Atomic uint64_t *steps)
{
    if (steps) atomic_fetch_add_explicit(steps, 1, memory_order_relaxed);
}

/* Embree calls this from any of its threads; false would end the build. */
static bool on_built(void *steps, double share)
{
    (void)share;
    step(steps);
    return true;
}

/* Frames build on their base's device: trees of one device alone stand together. */
static int device_create(struct render_scene *s, uint32_t threads, struct fault *fault)
{
    if (s->base) {
        s->device = s->base->device;
        rtcRetainDevice(s->device);
        s->isa = s->base->isa;
        s->packet_width = s->base->packet_width;
        return 0;
    }
    const char *isa = build_isa();
    if (!isa)
        return fault_set(fault, ERR_UNSUPPORTED, "cpu",
                         "this CPU lacks SSE 4.2, which tracing needs");
    char config[64];
    snprintf(config, sizeof config, "isa=%s,threads=%u", isa, threads ? threads : 1);
    s->device = rtcNewDevice(config);
    if (!s->device) {
        const enum RTCError error = rtcGetDeviceError(NULL);
        return fault_set(fault, error == RTC_ERROR_OUT_OF_MEMORY ? ERR_MEMORY : ERR_UNSUPPORTED,
                         "embree", "no device for \"%s\": error %d", config, (int)error);
    }
    s->isa = isa;
    s->packet_width = 4;
    if (rtcGetDeviceProperty(s->device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED))
        s->packet_width = 8;
    if (rtcGetDeviceProperty(s->device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED))
        s->packet_width = 16;
    return 0;
}

/* Returns Embree's first error since the last call; it reports errors through its device. */
static int device_status(const struct render_scene *s, const char *place, struct fault *fault)
{
    enum RTCError error = rtcGetDeviceError(s->device);
    if (error == RTC_ERROR_NONE) return 0;
    int code = error == RTC_ERROR_OUT_OF_MEMORY ? ERR_MEMORY : ERR_LIMIT;
    return fault_set(fault, code, place, "Embree reports error %d", (int)error);
}

static void find_kinds(struct render_scene *s)
{
    for (uint64_t i = 0; i < s->blob->count[SCENE_MESHES]; i++) {
        const struct material *m = s->meshes[i].material;
        s->has_culled |= m->culled;
        s->has_glass |= m->transmissive || m->translucent;
    }
}

static RTCScene scene_new(const struct render_scene *s)
{
    RTCScene scene = rtcNewScene(s->device);
    if (!scene) return NULL;
    /* The filters are of camera rays (trace/hit/back_faces.h) and of those through glass
     * (glazing.h). Frames that stand on a base may have either. */
    const bool filters = s->has_culled || s->has_glass || is_base(s);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST |
                                (filters ? RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION : 0));
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM); /* same tree for any thread count */
    if (s->progress) rtcSetSceneProgressMonitorFunction(scene, on_built, (void *)s->progress);
    return scene;
}

/* Sets the vertices of a mesh, at each step of the shutter if it bends. */
static void set_vertices(const struct render_scene *s, const struct mesh_view *view, uint32_t count,
                         const struct scene_step *steps, RTCGeometry geometry)
{
    const uint32_t times = steps ? SHUTTER_STEPS : 1;
    rtcSetGeometryTimeStepCount(geometry, times);
    for (uint32_t k = 0; k < times; k++) {
        const float *at = view->positions;
        if (steps) at = s->blob->positions + (size_t)3 * steps[k].first_vertex;
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, k, RTC_FORMAT_FLOAT3, at, 0,
                                   3 * sizeof(float), count);
    }
}

/* Attaches the mesh's triangles as geometry `id` of `scene`, for rays with a bit of `mask`. The
 * blob keeps them. `steps`: it bends so; NULL: it does not. */
static void mesh_attach(struct render_scene *s, uint32_t index, RTCScene scene, uint32_t id,
                        uint32_t mask, const struct scene_step *steps)
{
    const struct scene_mesh *mesh = &s->blob->meshes[index];
    struct mesh_view *view = &s->meshes[index];
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return;
    set_vertices(s, view, mesh->vertex_count, steps, geometry);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               view->triangles, 0, 3 * sizeof(uint32_t), mesh->triangle_count);
    rtcSetGeometryUserData(geometry, view);
    rtcSetGeometryMask(geometry, mask);
    if (view->material->alpha_cutoff > 0.0f) {
        rtcSetGeometryIntersectFilterFunction(geometry, alpha_filter);
        rtcSetGeometryOccludedFilterFunction(geometry, alpha_filter);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
    s->built_triangles += mesh->triangle_count;
}

static int sub_scene_create(struct render_scene *s, uint32_t mesh, struct fault *fault)
{
    RTCScene scene = scene_new(s);
    if (!scene) return device_status(s, "meshes", fault);
    s->sub_scenes[mesh] = scene;
    mesh_attach(s, mesh, scene, 0, UINT32_MAX, NULL);
    rtcCommitScene(scene);
    return device_status(s, "meshes", fault);
}

/* `steps`: it moves so; NULL: it stands. */
static void scene_attach(struct render_scene *s, RTCScene scene, const float to_world[12],
                         const struct scene_step *steps, uint32_t id, uint32_t mask)
{
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (!geometry) return;
    rtcSetGeometryInstancedScene(geometry, scene);
    const uint32_t times = steps ? SHUTTER_STEPS : 1;
    rtcSetGeometryTimeStepCount(geometry, times);
    for (uint32_t k = 0; k < times; k++)
        rtcSetGeometryTransform(geometry, k, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                                steps ? steps[k].to_world : to_world);
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(s->top, geometry, id);
    rtcReleaseGeometry(geometry);
    s->has_instances = true;
}

static void instance_attach(struct render_scene *s, uint32_t index)
{
    const struct scene_instance *instance = &s->blob->instances[index];
    const bool is_based = s->blob->meshes[instance->mesh].flags & MESH_IN_BASE;
    RTCScene scene = (is_based ? s->base : s)->sub_scenes[instance->mesh];
    if (scene)
        scene_attach(s, scene, instance->to_world, mover_steps(s, index), index,
                     instance_class(instance));
}

/* Attaches instance `index`. A mesh placed once and untransformed needs no Embree instance. */
static int place(struct render_scene *s, uint32_t index, uint32_t uses, struct fault *fault)
{
    const struct scene_instance *instance = &s->blob->instances[index];
    const bool is_based = s->blob->meshes[instance->mesh].flags & MESH_IN_BASE;
    if (s->meshes[instance->mesh].triangle_count == 0) return 0;
    if (is_based) {
        instance_attach(s, index); /* unless the ground has it */
        return 0;
    }
    if (uses == 1 && instance->flags & INSTANCE_IDENTITY) {
        mesh_attach(s, instance->mesh, s->top, index, instance_class(instance),
                    mover_steps(s, index));
        return 0;
    }
    if (!s->sub_scenes[instance->mesh]) {
        int rc = sub_scene_create(s, instance->mesh, fault);
        if (rc) return rc;
    }
    instance_attach(s, index);
    return 0;
}

static int place_all(struct render_scene *s, struct fault *fault)
{
    uint32_t instances = (uint32_t)s->blob->count[SCENE_INSTANCES];
    uint32_t *uses = calloc((size_t)s->blob->count[SCENE_MESHES] + 1, sizeof *uses);
    if (!uses) return fault_set(fault, ERR_MEMORY, "meshes", "no memory to count their instances");
    for (uint32_t i = 0; i < instances; i++) uses[s->blob->instances[i].mesh]++;
    int rc = 0;
    if (s->base && s->base->top_count > 0) {
        static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        s->ground = instances;
        scene_attach(s, s->base->top, identity, NULL, s->ground, UINT32_MAX);
    }
    for (uint32_t i = 0; i < instances && rc == 0; i++) {
        rc = place(s, i, uses[s->blob->instances[i].mesh], fault);
        step(s->progress);
    }
    free(uses);
    return rc ? rc : device_status(s, "instances", fault);
}

/* Builds a base: of its instances those that stand alone are the ground of all frames; every other
 * mesh is a sub-scene for frames to place. */
static int build_base(struct render_scene *s, struct fault *fault)
{
    const uint32_t meshes = (uint32_t)s->blob->count[SCENE_MESHES];
    const uint32_t instances = (uint32_t)s->blob->count[SCENE_INSTANCES];
    uint32_t *uses = calloc((size_t)meshes + 1, sizeof *uses);
    if (!uses) return fault_set(fault, ERR_MEMORY, "meshes", "no memory to count their instances");
    s->top = scene_new(s);
    int rc = s->top ? 0 : device_status(s, "scene", fault);
    for (uint32_t i = 0; i < instances; i++) {
        const struct scene_instance *instance = &s->blob->instances[i];
        uses[instance->mesh] += instance->flags & INSTANCE_IDENTITY ? 1 : 2;
    }
    for (uint32_t i = 0; i < instances && rc == 0; i++) {
        const struct scene_instance *instance = &s->blob->instances[i];
        const uint32_t mesh = instance->mesh;
        if (uses[mesh] != 1 || s->meshes[mesh].triangle_count == 0) continue;
        mesh_attach(s, mesh, s->top, i, instance_class(instance), NULL);
        s->top_count++;
    }
    for (uint32_t i = 0; i < meshes && rc == 0; i++) {
        if (uses[i] != 1 && s->meshes[i].triangle_count > 0) rc = sub_scene_create(s, i, fault);
        step(s->progress);
    }
    free(uses);
    if (rc) return rc;
    rtcCommitScene(s->top);
    return device_status(s, "scene", fault);
}

static int build(struct render_scene *s, struct fault *fault)
{
    if (is_base(s)) return build_base(s, fault);
    s->top = scene_new(s);
    if (!s->top) return device_status(s, "scene", fault);
    int rc = place_all(s, fault);
    if (rc) return rc;
    rtcCommitScene(s->top);
    return device_status(s, "scene", fault);
}

/* Finds what shines, and where light is sent on otherwise than diffusely. */
static int find_light(struct render_scene *s, struct fault *fault)
{
    int rc = emitters_create(s, &s->emitters);
    if (rc) return fault_set(fault, rc, "meshes", "their emitting triangles are too many");
    const struct lobe_box *of_base = s->base ? s->base->boxes : NULL;
    rc = lobe_boxes_create(BOXES_OF_LOBES, s->blob, s->meshes, of_base, &s->lobes);
    if (!rc) rc = lobe_boxes_create(BOXES_OF_VIRTUAL, s->blob, s->meshes, of_base, &s->virtuals);
    return rc ? fault_set(fault, rc, "instances", "no memory for their boxes") : 0;
}

static int find_boxes(struct render_scene *s, struct fault *fault)
{
    const uint64_t meshes = s->blob->count[SCENE_MESHES];
    s->boxes = calloc(meshes + 1, sizeof *s->boxes);
    if (!s->boxes) return fault_set(fault, ERR_MEMORY, "meshes", "no memory for their boxes");
    for (uint64_t i = 0; i < meshes; i++) lobe_box_of_mesh(&s->meshes[i], &s->boxes[i]);
    return 0;
}

/* Learns where light comes from that no light sample finds. ERR_MEMORY. */
static int learn_light(struct render_scene *s)
{
    glazing_learn(s, &s->glazing);
    s->guides = sky_guides_create(s);
    if (!s->guides) return ERR_MEMORY;
    const int error = photon_targets_find(s, &s->targets);
    return error ? error : caustics_of_lamps(s, &s->caustics);
}

int render_scene_create(const struct scene *blob, uint32_t threads, _Atomic uint64_t *steps,
                        struct render_scene **out, struct fault *fault)
{
    return render_scene_create_on(blob, NULL, threads, steps, out, fault);
}

int render_scene_create_on(const struct scene *blob, const struct render_scene *base,
                           uint32_t threads, _Atomic uint64_t *steps, struct render_scene **out,
                           struct fault *fault)
{
    struct render_scene *s = aligned_alloc(_Alignof(struct render_scene), sizeof *s);
    if (!s) return fault_set(fault, ERR_MEMORY, "scene", "no memory for the scene");
    memset(s, 0, sizeof *s);
    int rc = ERR_MEMORY;
    size_t meshes = (size_t)blob->count[SCENE_MESHES];
    s->blob = blob;
    s->base = base;
    s->ground = RTC_INVALID_GEOMETRY_ID;
    s->progress = steps;
    s->meshes = calloc(meshes + 1, sizeof *s->meshes);
    s->sub_scenes = calloc(meshes + 1, sizeof(RTCScene));
    if (!s->meshes || !s->sub_scenes || material_table_create(blob, &s->materials) != 0) {
        fault_set(fault, rc, "meshes", "no memory for the tables of %zu meshes", meshes);
        goto fail;
    }
    for (uint32_t i = 0; i < meshes; i++) mesh_view_init(&s->meshes[i], blob, s->materials, i);
    find_kinds(s);
    if (movers_find(blob, &s->steps) != 0) {
        fault_set(fault, rc, "movers", "no memory for their steps");
        goto fail;
    }
    rc = is_base(s) ? find_boxes(s, fault) : find_light(s, fault);
    if (rc) goto fail;
    step(steps);
    rc = device_create(s, threads, fault);
    if (rc) goto fail;
    step(steps);
    rc = build(s, fault);
    if (rc) goto fail;
    if (!is_base(s)) {
        rc = learn_light(s);
        if (rc) fault_set(fault, rc, "scene", "no memory for what is learned of its light");
        if (rc) goto fail;
    }
    s->progress = NULL;
    *out = s;
    return 0;
fail:
    render_scene_destroy(&s);
    return rc;
}

void render_scene_destroy(struct render_scene **scene)
{
    struct render_scene *s = *scene;
    if (!s) return;
    sky_guides_destroy(&s->guides);
    photons_destroy(&s->caustics);
    free(s->targets);
    if (s->top) rtcReleaseScene(s->top);
    for (size_t i = 0; s->sub_scenes && i < (size_t)s->blob->count[SCENE_MESHES]; i++)
        if (s->sub_scenes[i]) rtcReleaseScene(s->sub_scenes[i]);
    if (s->device) rtcReleaseDevice(s->device);
    lobe_boxes_destroy(&s->lobes);
    lobe_boxes_destroy(&s->virtuals);
    emitters_destroy(&s->emitters);
    if (s->materials) material_table_destroy(&s->materials);
    free(s->steps);
    free(s->boxes);
    free(s->sub_scenes);
    free(s->meshes);
    free(s);
    *scene = NULL;
}
