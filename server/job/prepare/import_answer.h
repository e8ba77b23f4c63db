#pragma once
/* Why the importer refused a file: {"ok": false, "code": "RANGE", "pointer": "meshes[3]", "detail":
 * "..."}. */
#include <jansson.h>

#include "proto/error.h"

/* Sets the fault that a refusal tells of. Places are the scene file's own, so they go into the
 * sentence, but for those of the job document. `answer` may be NULL or of any shape. */
void import_answer_refusal(const json_t *answer, struct fault *fault);
