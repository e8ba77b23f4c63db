/* Finds the camera that a job means, and fits its view to the shape of the job's image. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/camera_fit.h"
#include "server/job/plan/plan_parts.h"

static bool normalize(float v[3])
{
    double length = sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] +
                         (double)v[2] * (double)v[2]);
    if (!(length > 0) || !isfinite(length)) return false;
    for (int i = 0; i < 3; i++) v[i] = (float)((double)v[i] / length);
    return true;
}

static void cross(const float a[3], const float b[3], float out[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = (float)((double)a[j] * (double)b[k] - (double)a[k] * (double)b[j]);
    }
}

/* The vertical field of view stays as given and the horizontal one follows the image's shape, so
 * that a wider image shows more at its sides. */
static void fit(struct plan_camera *c, double half_height, const struct job *job)
{
    c->half_height = (float)half_height;
    c->half_width = (float)(half_height * (double)job->width_px / (double)job->height_px);
}

static int look_at(const struct job *job, const double origin[3], struct plan_camera *out,
                   struct fault *fault)
{
    const struct job_camera *c = &job->camera;
    out->type = CAMERA_PERSPECTIVE;
    for (int i = 0; i < 3; i++) out->eye[i] = (float)((double)c->eye[i] - origin[i]);
    for (int i = 0; i < 3; i++) out->forward[i] = c->target[i] - c->eye[i];
    float up[3] = {c->up[0], c->up[1], c->up[2]};
    if (!normalize(out->forward))
        return fault_set(fault, ERR_RANGE, "/scene/camera/target", "the target is the eye");
    if (normalize(up)) cross(out->forward, up, out->right);
    if (!normalize(out->right))
        return fault_set(fault, ERR_RANGE, "/scene/camera/up", "up points along the view");
    cross(out->right, out->forward, out->up);
    normalize(out->up);
    fit(out, tan((double)c->yfov_deg * (M_PI / 360)), job);
    return 0;
}

static void from_scene(const struct job *job, const struct scene_camera *c, struct plan_camera *out)
{
    out->type = c->type;
    memcpy(out->eye, c->eye, sizeof out->eye);
    memcpy(out->right, c->right, sizeof out->right);
    memcpy(out->up, c->up, sizeof out->up);
    memcpy(out->forward, c->forward, sizeof out->forward);
    double half_height =
        c->type == CAMERA_ORTHOGRAPHIC ? (double)c->half_height : tan((double)c->yfov_rad / 2);
    fit(out, half_height, job);
    if (c->type == CAMERA_PERSPECTIVE && c->half_width > 0) out->half_width = c->half_width;
    out->centre_x = c->centre_x;
    out->centre_y = c->centre_y;
}

/* Refuses a camera's name with the sentence "there is no camera "x"; there are "a", "b"", as far as
 * the names fit. */
static int refuse_name(const struct scene *scene, const char *name, struct fault *fault)
{
    char known[256];
    size_t used = 0;
    known[0] = '\0';
    for (uint64_t i = 0; i < scene->count[SCENE_CAMERAS] && used < sizeof known - 40; i++) {
        const char *other = scene_name(scene, scene->cameras[i].name);
        int n =
            snprintf(known + used, sizeof known - used, "%s\"%.30s\"", i > 0 ? ", " : "", other);
        used += (size_t)n;
    }
    return fault_set(fault, ERR_NOT_FOUND, "/scene/camera",
                     "the scene has no camera \"%.100s\"; it has %s", name, known);
}

static int find(const struct job *job, const struct scene *scene, uint64_t *out,
                struct fault *fault)
{
    uint64_t count = scene->count[SCENE_CAMERAS];
    if (job->camera.kind == JOB_CAMERA_DEFAULT) {
        *out = scene->info->default_camera;
        return 0;
    }
    if (job->camera.kind == JOB_CAMERA_INDEX) {
        *out = job->camera.index;
        if (*out < count) return 0;
        return fault_set(fault, ERR_NOT_FOUND, "/scene/camera", "%u: the scene has %llu cameras",
                         job->camera.index, (unsigned long long)count);
    }
    for (*out = 0; *out < count; ++*out)
        if (!strcmp(scene_name(scene, scene->cameras[*out].name), job->camera.name)) return 0;
    return refuse_name(scene, job->camera.name, fault);
}

static int set_lens(const struct job *job, struct plan_camera *out, struct plan_report *report,
                    struct fault *fault)
{
    struct fault inner = {0};
    if (!(job->aperture_radius > 0)) {
        plan_skip(report, "effect lens", "the camera is a pinhole");
        return 0;
    }
    if (out->type == CAMERA_ORTHOGRAPHIC)
        return fault_set(fault, ERR_RANGE, "/lens",
                         "the camera is orthographic; only a perspective one can have a lens");
    out->aperture_radius = job->aperture_radius;
    out->focus_distance = job->focus_distance;
    out->blade_count = job->blades;
    out->blade_rotation_rad =
        (float)(remainder((double)job->blade_rotation_deg, 360) * (M_PI / 180));
    if (plan_camera_check(out, "camera", &inner) != 0)
        return fault_set(fault, inner.code, "/lens", "%s: %s", inner.pointer, inner.detail);
    report->effects |= EFFECT_LENS;
    return 0;
}

/* Lists the scene's cameras. */
static void list_cameras(const struct scene *scene, struct plan_report *report)
{
    for (uint64_t i = 0; i < scene->count[SCENE_CAMERAS] && i < LIMIT_CAMERAS_LISTED; i++)
        snprintf(report->cameras[report->camera_count++], sizeof report->cameras[0], "%.63s",
                 scene_name(scene, scene->cameras[i].name));
}

int plan_resolve_camera(const struct job *job, const struct scene *scene, struct plan_camera *out,
                        struct plan_report *report, struct fault *fault)
{
    struct fault inner = {0};
    uint64_t index;
    *out = (struct plan_camera){0};
    list_cameras(scene, report);
    if (job->camera.kind == JOB_CAMERA_LOOK_AT) {
        int error = look_at(job, scene->info->origin, out, fault);
        if (error) return error;
    } else {
        int error = find(job, scene, &index, fault);
        if (error) return error;
        const struct scene_camera *camera = &scene->cameras[index];
        struct scene_camera fitted = *camera;
        const struct scene_info *seen = scene->base ? scene->base->info : scene->info;
        if (camera->is_default && job->default_camera == JOB_VIEW_THREE_QUARTER)
            camera_fit(seen->bounds_min, seen->bounds_max,
                       (double)job->width_px / (double)job->height_px, &fitted);
        from_scene(job, &fitted, out);
        report->camera_is_default = camera->is_default != 0;
        snprintf(report->camera_name, sizeof report->camera_name, "%.63s",
                 scene_name(scene, camera->name));
    }
    if (plan_camera_check(out, "camera", &inner) != 0)
        return fault_set(fault, inner.code, "/scene/camera", "%s: %s", inner.pointer, inner.detail);
    return set_lens(job, out, report, fault);
}

/* Returns the scene's camera that the job means; SCENE_NONE: one that stands. */
static uint32_t moving_camera(const struct job *job, const struct scene *scene)
{
    uint64_t index;
    struct fault ignored;
    if (scene->count[SCENE_POSES] == 0 || job->camera.kind == JOB_CAMERA_LOOK_AT) return SCENE_NONE;
    if (find(job, scene, &index, &ignored) != 0 || scene->cameras[index].is_default)
        return SCENE_NONE;
    return (uint32_t)index;
}

bool plan_find_poses(const struct job *job, const struct scene *scene, struct plan *plan)
{
    const uint32_t index = moving_camera(job, scene);
    bool moved = false;
    for (uint32_t k = 0; k < SHUTTER_STEPS; k++) {
        struct plan_camera *pose = &plan->poses[k];
        *pose = plan->camera;
        if (index == SCENE_NONE) continue;
        from_scene(job, &scene->poses[index * SHUTTER_STEPS + k], pose);
        moved = moved || memcmp(pose, &plan->camera, sizeof *pose) != 0;
    }
    return moved;
}

int plan_find_camera(const struct job *job, const struct scene *scene, struct plan_camera *out,
                     struct fault *fault)
{
    struct plan_report *report = calloc(1, sizeof *report); /* large, and of no use here */
    struct job pinhole = *job;                              /* borrows its files */
    pinhole.aperture_radius = 0;
    if (!report) return fault_set(fault, ERR_MEMORY, "", "no memory for a camera");
    int error = plan_resolve_camera(&pinhole, scene, out, report, fault);
    free(report);
    return error;
}
