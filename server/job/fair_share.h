#pragma once
/* Shares workers among the tenants of one priority: start-time fair queueing (Goyal, Vin, Cheng
 * 1996) over samples. A tenant of weight 2 gets twice the samples of one of weight 1 while both
 * have work.
 *
 * Tenants with work stand in a line, one line per priority, and the least served goes first. A
 * tenant that comes, or comes back after a time without work, starts where the least served of the
 * others is: time away earns nothing. In an empty line, what it was served before does not count
 * against it. A tenant whose work cannot be served falls behind by FAIR_SHARE_CREDIT at most.
 *
 * Pure data. Which tile goes where changes no picture. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/store/job_store.h"

/* Samples of weight 1: some minutes of one machine. */
#define FAIR_SHARE_CREDIT ((uint64_t)1 << 30)

/* One tenant in the line of one priority. */
struct fair_tenant {
    struct fair_tenant *next;
    char owner[JOB_OWNER_BYTES];
    int32_t priority;
    size_t jobs;        /* with work; 0: away, but remembered while others are behind */
    uint32_t weight;    /* at least 1 */
    uint32_t rest;      /* samples that `served` does not show yet, below the weight */
    uint64_t served;    /* samples over weight, since the line began */
    size_t seen, ahead; /* scratch for passes over the jobs */
};

struct fair_weights {
    size_t count;
    struct fair_weight {
        char owner[JOB_OWNER_BYTES];
        uint32_t weight; /* at least 1 */
    } list[];
};

struct fair_share {
    struct fair_tenant *first;    /* owned, in no order */
    struct fair_weights *weights; /* owned; a tenant that is not listed has 1; NULL: all have 1 */
};

/* Sets the weights of tenants, and takes the list. What was served before stays as it was counted.
 */
void fair_share_weigh(struct fair_share *share, struct fair_weights *weights);

/* Adds one job with work to the owner's tenant. It stays where it is until as many leave. NULL when
 * memory is exhausted. */
struct fair_tenant *fair_share_join(struct fair_share *share, const char *owner, int32_t priority);
void fair_share_leave(struct fair_share *share, struct fair_tenant *tenant);
/* Charges the tenant for samples that its tiles take. */
void fair_share_charge(struct fair_share *share, struct fair_tenant *tenant, uint64_t samples);

/* Returns how many tenants have work. */
size_t fair_share_count(const struct fair_share *share, int32_t priority);
/* Returns how many of them go before this one. */
size_t fair_share_rank(const struct fair_share *share, const struct fair_tenant *tenant);
/* Returns the tenant that goes first; NULL: none has work. */
const struct fair_tenant *fair_share_next(const struct fair_share *share, int32_t priority);
/* Returns whether a goes before b. NULL, which has no account, goes before all that have one. */
bool fair_tenant_before(const struct fair_tenant *a, const struct fair_tenant *b);
/* Resets `seen` and `ahead` of all tenants. */
void fair_share_look(struct fair_share *share);

void fair_share_fini(struct fair_share *share);
