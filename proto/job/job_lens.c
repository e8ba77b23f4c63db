#include "proto/job/job_internal.h"

#define JOB(member) offsetof(struct job, member)

static const struct json_member lens_members[] = {{.name = "aperture_radius",
                                                   .read = json_member_f32,
                                                   .offset = JOB(aperture_radius),
                                                   .min = 0,
                                                   .max = LIMIT_COORDINATE,
                                                   .required = true},
                                                  {.name = "focus_distance",
                                                   .read = json_member_f32,
                                                   .offset = JOB(focus_distance),
                                                   .min = 0,
                                                   .max = LIMIT_COORDINATE},
                                                  {.name = "blades",
                                                   .read = json_member_u32,
                                                   .offset = JOB(blades),
                                                   .min = 0,
                                                   .max = LIMIT_LENS_BLADES},
                                                  {.name = "blade_rotation_deg",
                                                   .read = json_member_f32,
                                                   .offset = JOB(blade_rotation_deg),
                                                   .min = -360,
                                                   .max = 360},
                                                  {.name = NULL}};

static int check(struct json_cursor *at, const json_t *value, const struct job *job)
{
    if (job->blades == 1 || job->blades == 2)
        return json_cursor_refuse_member(at, "blades", ERR_RANGE,
                                         "%u is neither 0 (round) nor from 3 to %d", job->blades,
                                         LIMIT_LENS_BLADES);
    if (!(job->aperture_radius > 0.0f)) return 0;
    if (!json_object_get(value, "focus_distance"))
        return json_cursor_refuse_member(at, "focus_distance", ERR_MISSING,
                                         "\"focus_distance\" is required: an aperture of radius "
                                         "%.9g has to be focused",
                                         (double)job->aperture_radius);
    if (!(job->focus_distance > 0.0f))
        return json_cursor_refuse_member(at, "focus_distance", ERR_RANGE, "%.9g is not above 0",
                                         (double)job->focus_distance);
    return 0;
}

int job_lens_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                  void *object)
{
    struct job *job = object;
    (void)member;
    if (json_is_null(value)) return 0;
    int error = json_cursor_members(at, value, lens_members, job);
    if (!error) error = check(at, value, job);
    if (error || job->aperture_radius > 0.0f) return error;
    job->focus_distance = job->blade_rotation_deg = job->aperture_radius = 0.0f;
    job->blades = 0;
    return 0;
}

json_t *job_lens_write(const struct job *job)
{
    if (!(job->aperture_radius > 0.0f)) return json_null();
    return json_pack("{s:o,s:o,s:i,s:o}", "aperture_radius", job_number_write(job->aperture_radius),
                     "focus_distance", job_number_write(job->focus_distance), "blades",
                     (int)job->blades, "blade_rotation_deg",
                     job_number_write(job->blade_rotation_deg));
}
