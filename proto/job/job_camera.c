#include "proto/job/job_internal.h"

#include <math.h>
#include <string.h>

#define CAMERA(member) offsetof(struct job_camera, member)

#define VECTOR(vector, must)                                                                       \
    {                                                                                              \
        .name = #vector, .read = json_member_f32x3, .offset = CAMERA(vector),                      \
        .min = -LIMIT_COORDINATE, .max = LIMIT_COORDINATE, .required = (must)                      \
    }

static const struct json_member look_at_members[] = {
    VECTOR(eye, true),
    VECTOR(target, true),
    VECTOR(up, false),
    {.name = "yfov_deg", .read = json_member_f32, .offset = CAMERA(yfov_deg), .min = 0, .max = 179},
    {.name = NULL}};

/* Eye, target and up must span a frame. */
static int check_look_at(struct json_cursor *at, const struct job_camera *c)
{
    double view[3], up[3], side[3];
    for (int i = 0; i < 3; i++) {
        view[i] = (double)c->target[i] - (double)c->eye[i];
        up[i] = (double)c->up[i];
    }
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        side[i] = view[j] * up[k] - view[k] * up[j];
    }
    const double view_length = sqrt(view[0] * view[0] + view[1] * view[1] + view[2] * view[2]);
    const double up_length = sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
    const double side_length = sqrt(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
    if (!(view_length >= 1e-15))
        return json_cursor_refuse_member(at, "target", ERR_RANGE, "it is where the eye is");
    if (!(up_length >= 1e-15))
        return json_cursor_refuse_member(at, "up", ERR_RANGE, "it has no length");
    if (!(side_length > 1e-5 * view_length * up_length))
        return json_cursor_refuse_member(at, "up", ERR_RANGE, "it lies along the view");
    if (!(c->yfov_deg >= 1e-4f))
        return json_cursor_refuse_member(at, "yfov_deg", ERR_RANGE, "%.9g is below 0.0001",
                                         (double)c->yfov_deg);
    return 0;
}

static int read_look_at(struct json_cursor *at, const json_t *v, struct job_camera *camera)
{
    *camera = (struct job_camera){
        .kind = JOB_CAMERA_LOOK_AT, .up = {0.0f, 1.0f, 0.0f}, .yfov_deg = 45.0f};
    const int error = json_cursor_members(at, v, look_at_members, camera);
    return error ? error : check_look_at(at, camera);
}

static int read_camera_name(struct json_cursor *at, const json_t *v, struct job_camera *camera)
{
    if (json_string_length(v) >= LIMIT_NAME_BYTES)
        return json_cursor_refuse(at, ERR_LIMIT, "a name of %zu bytes is above the limit of %d",
                                  json_string_length(v), LIMIT_NAME_BYTES - 1);
    camera->kind = JOB_CAMERA_NAME;
    memcpy(camera->name, json_string_value(v), json_string_length(v) + 1);
    return 0;
}

int job_camera_read(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    struct job_camera *camera = &((struct job *)o)->camera;
    int64_t index = 0;
    (void)m;
    if (json_is_null(v)) return 0;
    if (json_is_string(v)) return read_camera_name(at, v, camera);
    if (json_is_object(v)) return read_look_at(at, v, camera);
    if (!json_is_number(v))
        return json_cursor_refuse(at, ERR_TYPE,
                                  "it must be a camera's name, its index or an object");
    const int error = json_cursor_whole(at, v, 0, LIMIT_CAMERAS - 1, &index);
    if (error) return error;
    camera->kind = JOB_CAMERA_INDEX;
    camera->index = (uint32_t)index;
    return 0;
}

/* jansson's setters take NULL for a failed allocation and say so. */
static json_t *checked(json_t *object, int failures)
{
    if (failures == 0) return object;
    json_decref(object);
    return NULL;
}

json_t *job_camera_write(const struct job_camera *camera)
{
    if (camera->kind == JOB_CAMERA_DEFAULT) return json_null();
    if (camera->kind == JOB_CAMERA_NAME) return json_string(camera->name);
    if (camera->kind == JOB_CAMERA_INDEX) return json_integer(camera->index);
    json_t *object = json_object();
    int failures = json_object_set_new(object, "eye", job_number_write3(camera->eye));
    failures += json_object_set_new(object, "target", job_number_write3(camera->target));
    failures += json_object_set_new(object, "up", job_number_write3(camera->up));
    failures += json_object_set_new(object, "yfov_deg", job_number_write(camera->yfov_deg));
    return checked(object, failures);
}
