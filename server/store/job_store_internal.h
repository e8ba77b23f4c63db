#pragma once
/* The store itself, for the files that make requests to it. */
#include "server/store/job_batches.h"
#include "server/store/job_request.h"
#include "server/store/removal_timer.h"

struct job_store {
    struct job_batches batches;
    struct job_database *db;
    int lock_fd;
    bool searching; /* for a text in all jobs */
    struct asset_room room;
    struct removal_timer removals;
    struct removal_pass pass; /* the last one */
};

/* Looks for removals that are due. */
void job_store_look_at_removals(struct job_store *s);
/* Gives a request the assets that the owner must have. ERR_MEMORY. */
int job_store_claim_assets(struct job_store *s, struct job_request *r, const char *owner,
                           const struct job_assets *assets);
