#pragma once
/* The lights of a job document. */
#include "proto/job/job.h"

/* Reader of the member "lights" into a struct job, and its writer: NULL on failed allocation. */
int job_lights_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *job);
json_t *job_lights_write(const struct job *job);
