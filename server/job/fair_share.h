#pragma once
/* Whose turn it is among tenants of one priority: start-time fair queueing (Goyal, Vin, Cheng 1996)
 * over samples. A tenant of weight 2 gets twice the samples of one of weight 1 while both have
 * work.
 *
 * A tenant with work stands in a line, one for each priority; who has been served least goes first.
 * One who comes, or comes back after a time without work, starts where the least served of those
 * who stayed is: time away earns nothing. Nor does what he was served before weigh on one who finds
 * the line empty. Who has work that could not be served falls behind by FAIR_SHARE_CREDIT at most.
 *
 * Pure data; which tile goes where changes no picture. */
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
    size_t jobs;        /* that have work; 0: away, but remembered, as others are behind */
    uint32_t weight;    /* at least 1 */
    uint32_t rest;      /* samples that `served` does not show yet, below the weight */
    uint64_t served;    /* samples over weight; counted from the beginning of the line */
    size_t seen, ahead; /* scratch of who goes through the jobs */
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
    struct fair_weights *weights; /* owned; who is not there has 1; NULL: everybody */
};

/* From now on tenants have these weights, which are taken; what they were given before stays as it
 * was counted. */
void fair_share_weigh(struct fair_share *share, struct fair_weights *weights);

/* One more job of the owner has work; NULL when memory is exhausted. It stays where it is until as
 * many leave. */
struct fair_tenant *fair_share_join(struct fair_share *share, const char *owner, int32_t priority);
void fair_share_leave(struct fair_share *share, struct fair_tenant *tenant);
/* It is given that many samples to trace. */
void fair_share_charge(struct fair_share *share, struct fair_tenant *tenant, uint64_t samples);

/* Tenants with work. */
size_t fair_share_count(const struct fair_share *share, int32_t priority);
/* Of them those who go before this one. */
size_t fair_share_rank(const struct fair_share *share, const struct fair_tenant *tenant);
/* Who goes first; NULL: nobody has work. */
const struct fair_tenant *fair_share_next(const struct fair_share *share, int32_t priority);
/* Does a go before b? NULL, of which there is no account, goes before all who were served. */
bool fair_tenant_before(const struct fair_tenant *a, const struct fair_tenant *b);
/* Begins anew to count what is seen. */
void fair_share_look(struct fair_share *share);

void fair_share_fini(struct fair_share *share);
