#pragma once
/* How many jobs that have not ended each tenant has: for a quota. Pure data. */
#include <stddef.h>

#include "server/store/job_store.h"

struct job_count {
    struct job_count *next;
    size_t jobs; /* > 0 */
    char owner[JOB_OWNER_BYTES];
};

struct job_counts {
    struct job_count *first; /* owned */
};

/* One more, if the owner does not have `most` already; 0: as many as there are. ERR_QUOTA,
 * ERR_MEMORY. */
int job_counts_take(struct job_counts *counts, const char *owner, size_t most);
/* One less. */
void job_counts_give(struct job_counts *counts, const char *owner);
size_t job_counts_of(const struct job_counts *counts, const char *owner);
void job_counts_fini(struct job_counts *counts);
