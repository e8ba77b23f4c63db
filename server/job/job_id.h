#pragma once
/* Ids of jobs: 26 characters that sort by time of creation. As in ULIDs they are 48 bits of
 * milliseconds and 80 random ones, in Crockford's base 32, lower case. */
#include <stdbool.h>
#include <stdint.h>

#include "server/store/job_store.h"

struct job_id_source {
    uint64_t last_ms;
    uint8_t random[10];
};

/* Makes the next id, which grows even when the clock stands or steps back. ERR_IO without
 * randomness. */
int job_id_next(struct job_id_source *source, uint64_t now_ms, char out[JOB_ID_BYTES]);

/* Lets all ids that follow be greater than one that is valid: of an earlier process, perhaps under
 * a clock that was ahead. */
void job_id_follow(struct job_id_source *source, const char *id);

/* Returns whether a text from outside has the form of an id. */
bool job_id_is_valid(const char *text);
