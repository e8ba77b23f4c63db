#include "proto/job/job_internal.h"

#define JOB(member) offsetof(struct job, member)

static const struct json_member shutter_members[] = {
    {.name = "fraction",
     .read = json_member_f32,
     .offset = JOB(shutter_fraction),
     .min = 0,
     .max = 1,
     .required = true},
    {.name = "centre", .read = json_member_f32, .offset = JOB(shutter_centre), .min = -1, .max = 1},
    {.name = NULL}};

/* A number is a fraction. */
static int read_shutter(struct json_cursor *at, const struct json_member *member,
                        const json_t *value, void *object)
{
    struct job *job = object;
    (void)member;
    if (json_is_null(value)) return 0;
    if (json_is_number(value)) return json_member_f32(at, &shutter_members[0], value, object);
    int error = json_cursor_expect(at, value, JSON_OBJECT,
                                   "a fraction of a frame, {\"fraction\": "
                                   "...} or null");
    if (!error) error = json_cursor_members(at, value, shutter_members, job);
    if (!(job->shutter_fraction > 0.0f)) job->shutter_centre = 0.0f;
    return error;
}

const struct json_member job_shutter_members[] = {{.name = "shutter", .read = read_shutter},
                                                  {.name = NULL}};

json_t *job_shutter_write(const struct job *job)
{
    if (!(job->shutter_fraction > 0.0f)) return json_pack("{s:n}", "shutter");
    return json_pack("{s:{s:o,s:o}}", "shutter", "fraction",
                     job_number_write(job->shutter_fraction), "centre",
                     job_number_write(job->shutter_centre));
}

double job_shutter_s(const struct job *job)
{
    return job->stands ? 0 : (double)job->shutter_fraction / job->fps;
}
