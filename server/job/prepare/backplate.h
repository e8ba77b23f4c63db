#pragma once
/* Makes a job's plate of the blob that its backplate was imported as. */
#include "proto/job/job.h"
#include "server/image/plate.h"
#include "server/store/objects.h"

/* Blocking. ERR_MAGIC for a scene, ERR_MISMATCH where the fit is exact and the size another,
 * ERR_MEMORY; *fault has the place in the document. */
int backplate_make(const struct objects *objects, const struct digest *blob, const struct job *job,
                   struct plate **out, struct fault *fault);
