#pragma once
/* Finds the blobs of scenes and environment maps. A blob that is missing is imported once, however
 * many jobs ask for it. */
#include "proto/job/job.h"
#include "server/job/prepare/import_process.h"
#include "server/store/job_store.h"

struct imports;
struct import_request; /* a waiting request */

/* Tells the outcome. fault NULL: *blob is an object. cpu_us is that of the importer. */
typedef void (*import_done)(void *ctx, const struct fault *fault, const struct digest *blob,
                            uint64_t cpu_us);

int imports_create(const struct import_options *options, struct job_store *store,
                   struct imports **out);

/* Kills running imports. No callbacks come any more. */
void imports_stop(struct imports *imports);

/* Frees the imports, after imports_stop, once store and pool have let go. Nulls the pointer. */
void imports_destroy(struct imports **imports);

/* Requests a blob. Of `scene` the main file, its files, variant, animation, `stands`, time_s and
 * shutter count, but not its frames. An environment map is a scene of one file that stands. `scene`
 * is borrowed for the call. With `times`, the first of which is time_s, the blobs of the others are
 * made on the way, for later requests. `done` comes later, once, unless forgotten; the request is
 * gone then. The imports hold the blob, if at all, so the caller releases nothing. cpu_us is
 * charged to the first request. After ERR_MEMORY no import has begun, and `done` does not come. */
int imports_request(struct imports *imports, const struct job *scene,
                    const struct import_times *times, import_done done, void *ctx,
                    struct import_request **out);

/* Forgets a request, and kills an import that no request waits for. Nulls the pointer. */
void imports_forget(struct import_request **request);

/* Computes a digest of what a blob depends on: the importer's build, the main file, each file's
 * name and bytes, and the variant, animation and time that are asked for. */
int imports_source(const struct job *scene, struct digest *out);
