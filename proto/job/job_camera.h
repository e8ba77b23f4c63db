#pragma once
/* The job document's camera: null, a name, an index, or an object {eye, target, up, yfov_deg}. */
#include "proto/job/job.h"

/* A json_member_read for struct job. null leaves the camera as it is, the scene's own at first. */
int job_camera_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *object);

/* New reference; NULL on failed allocation. */
json_t *job_camera_write(const struct job_camera *camera);
