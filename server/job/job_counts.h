#pragma once
/* The number of active jobs of each tenant, for quotas. Pure data. */
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

/* Counts one more, unless the owner has `most` already; 0: no quota. ERR_QUOTA, ERR_MEMORY. */
int job_counts_take(struct job_counts *counts, const char *owner, size_t most);
/* Counts one less. */
void job_counts_give(struct job_counts *counts, const char *owner);
void job_counts_fini(struct job_counts *counts);
