#pragma once
/* The job document's thin lens. */
#include "proto/job/job.h"

/* A json_member_read for struct job. null, and an aperture of radius 0: no lens, and then all
 * fields are 0. */
int job_lens_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                  void *object);

/* null without a lens. New reference; NULL on failed allocation. */
json_t *job_lens_write(const struct job *job);
