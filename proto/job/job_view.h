#pragma once
/* What of a live job is moved while it is open: its camera and its lens. */
#include "proto/job/job.h"

/* Reads {"camera": ..., "lens": ...} over a copy of a job: each member as the job document has it,
 * and the whole of it; what is absent stays. At least one must be there. On failure *fault has the
 * code, the JSON pointer and a sentence. What the camera points to (files) stays the job's. */
int job_view_read(const char *text, size_t size_bytes, struct job *job, struct fault *fault);
