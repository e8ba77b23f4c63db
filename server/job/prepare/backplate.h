#pragma once
/* Makes a job's plate of the blob that its backplate was imported as. */
#include "proto/job/job.h"
#include "server/image/plate.h"
#include "server/job/plan/plan.h"
#include "server/store/objects.h"

/* Finds the photograph of a frame: the job's, or the file that the blob of the frame's scene names.
 * Borrows from the job. NULL: it is not among the job's files. */
const struct digest *backplate_find(const struct objects *objects, const struct digest *scene,
                                    const struct job *job);

/* Finds how workers are to see the photograph. Blocking. ERR_MAGIC for a scene; *fault has the
 * place in the document. */
int backplate_describe(const struct objects *objects, const struct digest *blob,
                       const struct job *job, struct plan_photograph *out, struct fault *fault);

/* Blocking. What was wrong with the file is added to the report. ERR_MAGIC for a scene,
 * ERR_MISMATCH where the fit is exact and the size another, ERR_MEMORY; *fault has the place in the
 * document. */
int backplate_make(const struct objects *objects, const struct digest *blob, const struct job *job,
                   struct plate **out, struct plan_report *report, struct fault *fault);
