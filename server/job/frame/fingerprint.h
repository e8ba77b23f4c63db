#pragma once
/* A job's fingerprint: all that its picture depends on, as 16 hexadecimal digits. */
#include "proto/job/job.h"

#define FINGERPRINT_BYTES 17

/* Makes a digest of the document with every default spelled out, less what only says how the work
 * is done (priority, live, tile_px) or how files hold the
 * picture. It stands in the EXR files in place of the job's id, because
 * equal jobs must give equal bytes whatever their number, tiles or workers. ERR_MEMORY. */
int fingerprint_of(const struct job *job, char out[FINGERPRINT_BYTES]);
