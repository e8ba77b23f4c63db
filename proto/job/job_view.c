#include "proto/job/job_internal.h"

/* null is a value here: the scene's own camera. */
static int read_camera(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o)
{
    ((struct job *)o)->camera = (struct job_camera){.kind = JOB_CAMERA_DEFAULT};
    return job_camera_read(at, m, v, o);
}

/* And no lens. */
static int read_lens(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    struct job *job = o;
    job->aperture_radius = job->focus_distance = job->blade_rotation_deg = 0.0f;
    job->blades = 0;
    return job_lens_read(at, m, v, o);
}

static const struct json_member view_members[] = {{.name = "camera", .read = read_camera},
                                                  {.name = "lens", .read = read_lens},
                                                  {.name = "moves", .read = job_moves_read},
                                                  {.name = NULL}};

int job_view_read(const char *text, size_t size_bytes, struct job *job, struct fault *fault)
{
    struct json_cursor at;
    json_t *document;
    int error = json_read(text, size_bytes, LIMIT_JOB_BYTES, &document, fault);
    if (error) return error;
    json_cursor_init(&at, fault);
    error = json_cursor_members(&at, document, view_members, job);
    if (!error && json_object_size(document) == 0)
        error = json_cursor_refuse(&at, ERR_MISSING, "give \"camera\", \"lens\" or \"moves\"");
    json_decref(document);
    return error;
}
