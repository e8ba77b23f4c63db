/* The job document's sampling.field_scale. */
#include <string.h>

#include "proto/job/job_internal.h"

int job_field_scale_read(struct json_cursor *at, const struct json_member *member,
                         const json_t *value, void *object)
{
    struct job *job = object;
    (void)member;
    if (json_is_string(value) && strcmp(json_string_value(value), "auto") == 0) {
        job->field_scale = FIELD_SCALE_AUTO;
        return 0;
    }
    if (!json_is_number(value))
        return json_cursor_refuse(at, ERR_TYPE, "expected 1, 0.5 or \"auto\"");
    const double scale = json_number_value(value);
    if (scale == 1.0)
        job->field_scale = FIELD_SCALE_FULL;
    else if (scale == 0.5)
        job->field_scale = FIELD_SCALE_HALF;
    else
        return json_cursor_refuse(at, ERR_RANGE, "%.9g is neither 1 nor 0.5", scale);
    return 0;
}

json_t *job_field_scale_write(enum field_scale scale)
{
    switch (scale) {
    case FIELD_SCALE_FULL:
        return json_integer(1);
    case FIELD_SCALE_HALF:
        return json_real(0.5);
    default:
        return json_string("auto");
    }
}
