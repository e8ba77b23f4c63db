#pragma once
/* The job document's environment: a map (.hdr, .exr) or the same radiance from everywhere. */
#include "proto/job/job.h"

/* A json_member_read for struct job. null: none. */
int job_environment_read(struct json_cursor *at, const struct json_member *member,
                         const json_t *value, void *object);

/* null without an environment. New reference; NULL on failed allocation. */
json_t *job_environment_write(const struct job_environment *environment);
