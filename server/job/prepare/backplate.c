#include "server/job/prepare/backplate.h"

#include <stdlib.h>
#include <string.h>

#include "proto/scene/environment.h"
#include "proto/scene/scene.h"
#include "server/image/tonemap.h"

static const char *place_of(const struct job *job)
{
    return job->composite.rgbd ? "/rgbd" : "/backplate";
}

static int check_size(const struct environment_header *header, const struct job *job,
                      struct fault *fault)
{
    const bool same =
        (int64_t)header->width_px == job->width_px && (int64_t)header->height_px == job->height_px;
    if (job->composite.fit != PLATE_FIT_EXACT || same) return 0;
    return fault_set(fault, ERR_MISMATCH, place_of(job),
                     "the photograph has %u x %u px, the picture %d x %d: give image that size, or "
                     "\"fit\" %sstretch",
                     header->width_px, header->height_px, job->width_px, job->height_px,
                     job->composite.rgbd ? "" : "cover or ");
}

const struct digest *backplate_find(const struct objects *objects, const struct digest *scene,
                                    const struct job *job)
{
    char path[OBJECTS_PATH_BYTES], name[LIMIT_NAME_BYTES];
    if (job->composite.has_plate) return &job->composite.plate;
    objects_path(objects, scene, path);
    if (scene_find_plate(path, name) != 0) return NULL;
    for (uint32_t i = 0; i < job->file_count; i++)
        if (strcmp(job->files[i].path, name) == 0) return &job->files[i].asset;
    return NULL;
}

/* Returns whether the importer has taken linear samples as sRGB. */
static bool is_encoded(const struct environment_blob *e, const struct job *job)
{
    return job->composite.color == PLATE_COLOR_LINEAR &&
           (e->header->flags & ENVIRONMENT_IS_PHOTOGRAPH);
}

/* Takes that back. */
static float *make_linear(const struct environment_blob *e)
{
    const size_t count = 3 * (size_t)e->header->width_px * e->header->height_px;
    float *out = malloc(count * sizeof *out);
    for (size_t i = 0; out && i < count; i++) out[i] = tonemap_srgb(e->texels[i]);
    return out;
}

static int make(const struct environment_blob *e, const struct job *job, struct plate **out,
                struct fault *fault)
{
    int error = check_size(e->header, job, fault);
    if (error) return error;
    const bool turn_back = is_encoded(e, job);
    const enum plate_scaling scaling =
        job->composite.fit == PLATE_FIT_COVER ? PLATE_COVER : PLATE_STRETCH;
    float *linear = turn_back ? make_linear(e) : NULL;
    error = turn_back && !linear ? ERR_MEMORY : 0;
    if (!error)
        error = plate_create(linear ? linear : e->texels, (int32_t)e->header->width_px,
                             (int32_t)e->header->height_px, job->width_px, job->height_px, scaling,
                             out);
    free(linear);
    return error ? fault_set(fault, error, place_of(job), "no memory for the photograph") : 0;
}

static int open_blob(const struct objects *objects, const struct digest *blob,
                     struct environment_blob *out, struct fault *fault)
{
    char path[OBJECTS_PATH_BYTES];
    objects_path(objects, blob, path);
    const int error = environment_map(path, out, fault);
    if (error == ERR_MAGIC)
        return fault_set(fault, error, "/backplate/asset", "this file is a scene, no photograph");
    if (!error) return 0;
    const struct fault inner = *fault;
    return fault_set(fault, error, "/backplate/asset", "its blob: %s: %s", inner.pointer,
                     inner.detail);
}

int backplate_describe(const struct objects *objects, const struct digest *blob,
                       const struct job *job, struct plan_photograph *out, struct fault *fault)
{
    struct environment_blob e;
    const bool covers = job->composite.fit == PLATE_FIT_COVER;
    const int error = open_blob(objects, blob, &e, fault);
    if (error) return error;
    *out = (struct plan_photograph){.fit = covers ? PHOTOGRAPH_COVERS : PHOTOGRAPH_STRETCHED,
                                    .is_linear = is_encoded(&e, job),
                                    .blob = *blob};
    environment_unmap(&e);
    return 0;
}

int backplate_make(const struct objects *objects, const struct digest *blob, const struct job *job,
                   struct plate **out, struct plan_report *report, struct fault *fault)
{
    struct environment_blob e;
    const int error = open_blob(objects, blob, &e, fault);
    if (error) return error;
    plan_copy_warnings(e.warnings, e.header->warning_bytes, report);
    const int made = make(&e, job, out, fault);
    environment_unmap(&e);
    return made;
}
