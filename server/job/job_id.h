#pragma once
/* Names of jobs: 26 characters that sort by time of creation (as ULIDs do: 48 bits of milliseconds,
 * 80 random ones, Crockford's base 32 in lower case). */
#include <stdbool.h>
#include <stdint.h>

#include "server/store/job_store.h"

struct job_id_source {
    uint64_t last_ms;
    uint8_t random[10];
};

/* The next one; grows even when the clock stands or steps back. ERR_IO without randomness. */
int job_id_next(struct job_id_source *source, uint64_t now_ms, char out[JOB_ID_BYTES]);

/* Whether a text from outside can be a name at all. */
bool job_id_is_valid(const char *text);
