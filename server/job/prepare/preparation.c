#include "server/job/prepare/preparation.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/prepare/backplate.h"
#include "server/job/prepare/frame_motion.h"
#include "server/job/prepare/matte_manifest.h"
#include "server/reconstruct/oidn/oidn_library.h"

struct preparation {
    struct pool_task task; /* first */
    struct thread_pool *pool;
    struct imports *imports;
    const struct objects *objects;
    struct import_request *request;
    struct prepared *prepared; /* owned until told */
    struct digest scene_blob, map_blob, plate_blob;
    struct plan_photograph photograph;
    bool is_later;                          /* another frame has the plate */
    struct digest side_blobs[MOTION_SIDES]; /* of motion, which has_motion tells of */
    unsigned side;                          /* that is imported */
    bool has_motion;
    struct fault fault;
    bool planning; /* on the pool */
    bool cancelled;
    preparation_done done;
    void *ctx;
};

static bool has_map(const struct preparation *p)
{
    return p->prepared->job.environment.kind == ENVIRONMENT_MAP;
}

static bool has_plate(const struct preparation *p)
{
    const struct job_composite *c = &p->prepared->job.composite;
    return c->rgbd || c->has_plate;
}

/* Frames that measured depth have a plate each; others share one. */
static bool makes_plate(const struct preparation *p)
{
    return p->prepared->job.composite.rgbd || (has_plate(p) && !p->is_later);
}

static void destroy(struct preparation *p)
{
    prepared_destroy(&p->prepared);
    free(p);
}

/* A blob that cannot be used is the asset's fault. The importer tells scenes and maps apart by
 * themselves: one in place of the other comes this far. */
static int blame(struct preparation *p, const char *pointer, const char *kind)
{
    const struct fault inner = p->fault;
    if (inner.code == ERR_MAGIC)
        return fault_set(&p->fault, ERR_MAGIC, pointer, "this file is %s", kind);
    return fault_set(&p->fault, inner.code, pointer, "its blob: %s: %s", inner.pointer,
                     inner.detail);
}

/* Opens what a scene stands on, unless that is the base that was given. */
static int find_base(struct preparation *p, const char *path)
{
    struct digest digest;
    struct prepared *out = p->prepared;
    int error = scene_find_base(path, &digest);
    if (error) return fault_set(&p->fault, error, "", "it cannot be read");
    if (out->base && digest_equal(shared_base_digest(out->base), &digest)) return 0;
    shared_base_unref(&out->base);
    if (digest_is_zero(&digest)) return 0;
    return shared_base_open(p->objects, &digest, &out->base, &p->fault);
}

static int find_side(struct preparation *p, unsigned side, struct scene *scene,
                     struct plan_camera *camera)
{
    char path[OBJECTS_PATH_BYTES];
    objects_path(p->objects, &p->side_blobs[side], path);
    int error = scene_map_on(path, shared_base_scene(p->prepared->base), scene, &p->fault);
    return error ? error : plan_find_camera(&p->prepared->job, scene, camera, &p->fault);
}

/* Compares the frame's scene with the one before and the one after it. */
static int find_motion(struct preparation *p, const struct scene *now, bool *camera_stands)
{
    struct plan_camera camera;
    struct scene scenes[MOTION_SIDES] = {{.blob = NULL}};
    struct plan_camera cameras[MOTION_SIDES];
    const struct scene *const sides[MOTION_SIDES] = {&scenes[0], &scenes[1]};
    int error = plan_find_camera(&p->prepared->job, now, &camera, &p->fault);
    for (unsigned side = 0; side < MOTION_SIDES && !error; side++)
        error = find_side(p, side, &scenes[side], &cameras[side]);
    if (!error && frame_motion_create(now, sides, cameras, &p->prepared->motion) != 0)
        error = fault_set(&p->fault, ERR_MEMORY, "/layers", "no memory for motion");
    for (unsigned side = 0; side < MOTION_SIDES; side++)
        if (scenes[side].blob) scene_unmap(&scenes[side]);
    *camera_stands = !error && motion_keeps_view(p->prepared->motion, &camera);
    return error;
}

/* map: the job's, or NULL. */
static int plan_scene(struct preparation *p, const struct environment_blob *map)
{
    struct scene scene;
    struct environment_header estimate;
    struct prepared *out = p->prepared;
    char path[OBJECTS_PATH_BYTES];
    objects_path(p->objects, &p->scene_blob, path);
    int error = find_base(p, path);
    if (!error) error = scene_map_on(path, shared_base_scene(out->base), &scene, &p->fault);
    if (error) return blame(p, "/scene/asset", "an environment map, no scene");
    struct plan_source source = {.scene = &scene,
                                 .scene_blob = p->scene_blob,
                                 .map = map ? map->header : NULL,
                                 .map_warnings = map ? map->warnings : NULL,
                                 .map_blob = p->map_blob,
                                 .photograph = p->photograph};
    error = prepared_find_light(out, p->objects, &scene, &estimate, &source, &p->fault);
    out->moves = (scene.info->flags & SCENE_MOVES) && !out->job.stands;
    source.camera_stands = !out->moves;
    if (!error && p->has_motion) error = find_motion(p, &scene, &source.camera_stands);
    if (!error)
        error = plan_make(&out->job, &source, out->number, &out->plan, &out->report, &p->fault);
    if (!error && out->moves && !out->motion && !out->job.composite.rgbd && out->plan.temporal > 0)
        plan_temporal_none("it is not known how the scene moves", &out->plan, &out->report);
    if (!error && matte_manifest_make(&out->job, &scene, &out->report, &out->mattes) != 0)
        error = fault_set(&p->fault, ERR_MEMORY, "/layers", "no memory for a manifest of names");
    if (!error && out->job.live && scene_parts_find(&scene, &out->parts, &out->part_count) != 0)
        error = fault_set(&p->fault, ERR_MEMORY, "", "no memory for the scene's nodes");
    if (!error && out->job.live)
        out->scene = scene;
    else
        scene_unmap(&scene);
    return error;
}

static int plan_with_map(struct preparation *p)
{
    struct environment_blob map;
    char path[OBJECTS_PATH_BYTES];
    if (!has_map(p)) return plan_scene(p, NULL);
    objects_path(p->objects, &p->map_blob, path);
    if (environment_map(path, &map, &p->fault) != 0)
        return blame(p, "/environment/asset", "a scene, no environment map (.hdr or .exr)");
    int error = 0;
    if (map.header->flags & ENVIRONMENT_IS_PHOTOGRAPH)
        error = fault_set(&p->fault, ERR_MAGIC, "/environment/asset",
                          "this file is a photograph, no environment map (.hdr or .exr)");
    if (!error) error = plan_scene(p, &map);
    if (!error && p->prepared->job.live)
        p->prepared->map = map;
    else
        environment_unmap(&map);
    return error;
}

static void plan_run(struct pool_task *task)
{
    struct preparation *p = (struct preparation *)task;
    struct fault told_later; /* when the loop asks for the library, which is then loaded */
    if (p->prepared->job.residual == RESIDUAL_OIDN) (void)oidn_library_get(&told_later);
    if (has_plate(p))
        p->fault.code = backplate_describe(p->objects, &p->plate_blob, &p->prepared->job,
                                           &p->photograph, &p->fault);
    if (!p->fault.code) p->fault.code = plan_with_map(p);
    if (!p->fault.code && makes_plate(p))
        p->fault.code = backplate_make(p->objects, &p->plate_blob, &p->prepared->job,
                                       &p->prepared->plate, &p->prepared->report, &p->fault);
}

static void tell(struct preparation *p)
{
    struct prepared *prepared = p->fault.code ? NULL : p->prepared;
    if (prepared) p->prepared = NULL;
    p->done(p->ctx, p->fault.code ? &p->fault : NULL, prepared);
    destroy(p);
}

static void plan_done(struct pool_task *task)
{
    struct preparation *p = (struct preparation *)task;
    if (p->cancelled) {
        destroy(p);
        return;
    }
    p->prepared->plan_cpu_us = task->cpu_us;
    tell(p);
}

static void start_planning(struct preparation *p)
{
    p->planning = true;
    p->task = (struct pool_task){.run = plan_run, .done = plan_done};
    thread_pool_submit(p->pool, &p->task);
}

/* A map or a plate was imported as a scene: a fault of a scene's asset is one of its. */
static void picture_imported(struct preparation *p, const struct fault *fault,
                             const struct digest *blob, uint64_t cpu_us, const char *pointer,
                             struct digest *out)
{
    p->request = NULL;
    if (!fault) {
        *out = *blob;
        p->prepared->import_cpu_us += cpu_us;
        return;
    }
    p->fault = *fault;
    if (strcmp(fault->pointer, "/scene/asset") == 0)
        snprintf(p->fault.pointer, sizeof p->fault.pointer, "%s", pointer);
    tell(p);
}

/* Imports a picture as a scene of one file. */
static void import_picture(struct preparation *p, const struct digest *asset, const char *what,
                           import_done done)
{
    const struct job file = {.scene = *asset, .stands = true};
    const struct import_times no_times = {0};
    int error = imports_request(p->imports, &file, &no_times, done, p, &p->request);
    if (!error) return;
    fault_set(&p->fault, error, "", "no memory to import the %s", what);
    tell(p);
}

static void plate_imported(void *ctx, const struct fault *fault, const struct digest *blob,
                           uint64_t cpu_us)
{
    struct preparation *p = ctx;
    picture_imported(p, fault, blob, cpu_us,
                     p->prepared->job.composite.rgbd ? "/rgbd" : "/backplate/asset",
                     &p->plate_blob);
    if (!fault) start_planning(p);
}

static void import_plate(struct preparation *p)
{
    const struct digest *plate =
        has_plate(p) ? backplate_find(p->objects, &p->scene_blob, &p->prepared->job) : NULL;
    if (plate) {
        import_picture(p, plate, "backplate", plate_imported);
    } else if (has_plate(p)) {
        fault_set(&p->fault, ERR_NOT_FOUND, "/rgbd", "the frame's colour image is not there");
        tell(p);
    } else {
        start_planning(p);
    }
}

static void map_imported(void *ctx, const struct fault *fault, const struct digest *blob,
                         uint64_t cpu_us)
{
    struct preparation *p = ctx;
    picture_imported(p, fault, blob, cpu_us, "/environment/asset", &p->map_blob);
    if (!fault) import_plate(p);
}

static bool wants_motion(const struct preparation *p);
static void import_rest(struct preparation *p);

static void scene_imported(void *ctx, const struct fault *fault, const struct digest *blob,
                           uint64_t cpu_us)
{
    struct preparation *p = ctx;
    p->request = NULL;
    if (fault) {
        p->fault = *fault;
        tell(p);
        return;
    }
    p->scene_blob = *blob;
    p->prepared->import_cpu_us = cpu_us;
    p->has_motion = wants_motion(p);
    p->side = 0;
    import_rest(p);
}

/* A scene that stands on a base moves; but of what a camera measured, only the camera does. */
static bool wants_motion(const struct preparation *p)
{
    char path[OBJECTS_PATH_BYTES];
    struct digest base;
    const struct job *job = &p->prepared->job;
    if (!(job->layers & LAYERS_MOTION) && !job_may_be_temporal(job)) return false;
    if (job->live || job->composite.rgbd) return false;
    objects_path(p->objects, &p->scene_blob, path);
    return scene_find_base(path, &base) == 0 && !digest_is_zero(&base);
}

static void side_imported(void *ctx, const struct fault *fault, const struct digest *blob,
                          uint64_t cpu_us)
{
    struct preparation *p = ctx;
    p->request = NULL;
    if (fault) {
        p->fault = *fault;
        tell(p);
        return;
    }
    p->side_blobs[p->side++] = *blob;
    p->prepared->import_cpu_us += cpu_us;
    import_rest(p);
}

/* The times of a frame and of those behind it. None of a job that stands. */
static struct import_times times_from(const struct job *job, int32_t number)
{
    struct import_times times = {0};
    uint32_t index;
    if (job->stands || !job_frame_find(job, number, &index)) return times;
    const uint32_t end = job_frame_count(job);
    for (; index < end && times.count < IMPORT_TIMES; index++)
        times.list[times.count++] = job_frame_time_s(job, job_frame_number(job, index));
    return times;
}

/* Imports the scene of the frame before, or of the one after: mostly they are there. */
static void import_side(struct preparation *p)
{
    struct job scene = p->prepared->job; /* borrows its files */
    const int32_t number = p->prepared->number + (p->side == MOTION_BACKWARD ? -1 : 1);
    scene.time_s = job_frame_time_s(&scene, number);
    struct import_times times = times_from(&scene, number);
    if (times.count == 0)
        times = (struct import_times){1, {scene.time_s}}; /* no frame of the job */
    int error = imports_request(p->imports, &scene, &times, side_imported, p, &p->request);
    if (!error) return;
    fault_set(&p->fault, error, "", "no memory to import the scene of another frame");
    tell(p);
}

/* Imports what is asked for beside the scene, one after the other; then plans. */
static void import_rest(struct preparation *p)
{
    if (p->has_motion && p->side < MOTION_SIDES)
        import_side(p);
    else if (has_map(p))
        import_picture(p, &p->prepared->job.environment.asset, "environment", map_imported);
    else
        import_plate(p);
}

int preparation_start(struct imports *imports, struct thread_pool *pool,
                      const struct objects *objects, struct job *job, int32_t number,
                      struct shared_base *base, preparation_done done, void *ctx,
                      struct preparation **out)
{
    struct preparation *p = calloc(1, sizeof *p);
    struct prepared *prepared = calloc(1, sizeof *prepared);
    if (!p || !prepared) {
        free(p);
        free(prepared);
        job_fini(job);
        return ERR_MEMORY;
    }
    prepared->job = *job;
    memset(job, 0, sizeof *job);
    prepared->number = number;
    prepared->base = shared_base_ref(base);
    prepared->job.time_s = job_frame_time_s(&prepared->job, number);
    *p = (struct preparation){.pool = pool,
                              .imports = imports,
                              .objects = objects,
                              .prepared = prepared,
                              .is_later = base != NULL,
                              .done = done,
                              .ctx = ctx};
    const struct import_times times = times_from(&prepared->job, number);
    int error = imports_request(imports, &prepared->job, &times, scene_imported, p, &p->request);
    if (error) {
        destroy(p);
        return error;
    }
    *out = p;
    return 0;
}

void preparation_cancel(struct preparation **preparation)
{
    struct preparation *p = *preparation;
    *preparation = NULL;
    if (!p) return;
    p->cancelled = true;
    if (p->request) imports_forget(&p->request);
    if (!p->planning) destroy(p);
}
