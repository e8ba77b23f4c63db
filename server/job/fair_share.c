#include "server/job/fair_share.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static bool is_in_line(const struct fair_tenant *tenant, int32_t priority)
{
    return tenant->jobs > 0 && tenant->priority == priority;
}

bool fair_tenant_before(const struct fair_tenant *a, const struct fair_tenant *b)
{
    return (a ? a->served : 0) < (b ? b->served : 0);
}

const struct fair_tenant *fair_share_next(const struct fair_share *share, int32_t priority)
{
    const struct fair_tenant *least = NULL;
    for (const struct fair_tenant *t = share->first; t; t = t->next)
        if (is_in_line(t, priority) && (!least || fair_tenant_before(t, least))) least = t;
    return least;
}

size_t fair_share_count(const struct fair_share *share, int32_t priority)
{
    size_t count = 0;
    for (const struct fair_tenant *t = share->first; t; t = t->next)
        count += is_in_line(t, priority);
    return count;
}

size_t fair_share_rank(const struct fair_share *share, const struct fair_tenant *tenant)
{
    size_t rank = 0;
    for (const struct fair_tenant *t = share->first; t; t = t->next)
        rank += is_in_line(t, tenant->priority) && fair_tenant_before(t, tenant);
    return rank;
}

static struct fair_tenant *find(const struct fair_share *share, const char *owner, int32_t priority)
{
    struct fair_tenant *t = share->first;
    while (t && (t->priority != priority || strcmp(t->owner, owner) != 0)) t = t->next;
    return t;
}

/* Forgets tenants that are away and would begin where all others are: nothing of them is worth
 * remembering. */
static void forget_settled(struct fair_share *share, int32_t priority)
{
    const struct fair_tenant *least = fair_share_next(share, priority);
    for (struct fair_tenant **at = &share->first; *at;) {
        struct fair_tenant *t = *at;
        if (t->priority != priority || t->jobs > 0 || (least && t->served > least->served)) {
            at = &t->next;
        } else {
            *at = t->next;
            free(t);
        }
    }
}

static uint32_t weight_of(const struct fair_share *share, const char *owner)
{
    for (size_t i = 0; share->weights && i < share->weights->count; i++)
        if (strcmp(share->weights->list[i].owner, owner) == 0)
            return share->weights->list[i].weight;
    return 1;
}

void fair_share_weigh(struct fair_share *share, struct fair_weights *weights)
{
    free(share->weights);
    share->weights = weights;
    for (struct fair_tenant *t = share->first; t; t = t->next) {
        t->weight = weight_of(share, t->owner);
        t->rest = 0;
    }
}

static struct fair_tenant *add(struct fair_share *share, const char *owner, int32_t priority)
{
    struct fair_tenant *t = calloc(1, sizeof *t);
    if (!t) return NULL;
    assert(strlen(owner) < sizeof t->owner);
    memcpy(t->owner, owner, strlen(owner) + 1);
    t->priority = priority;
    t->weight = weight_of(share, owner);
    t->next = share->first;
    share->first = t;
    return t;
}

struct fair_tenant *fair_share_join(struct fair_share *share, const char *owner, int32_t priority)
{
    struct fair_tenant *t = find(share, owner, priority);
    if (!t) t = add(share, owner, priority);
    if (!t) return NULL;
    if (t->jobs == 0) {
        const struct fair_tenant *least = fair_share_next(share, priority);
        if (least && t->served < least->served) t->served = least->served;
    }
    t->jobs++;
    return t;
}

void fair_share_leave(struct fair_share *share, struct fair_tenant *tenant)
{
    assert(tenant->jobs > 0);
    if (--tenant->jobs == 0) forget_settled(share, tenant->priority);
}

void fair_share_charge(struct fair_share *share, struct fair_tenant *tenant, uint64_t samples)
{
    const uint64_t start = tenant->served;
    samples += tenant->rest;
    tenant->served += samples / tenant->weight;
    tenant->rest = (uint32_t)(samples % tenant->weight);
    if (start <= FAIR_SHARE_CREDIT) return;
    for (struct fair_tenant *t = share->first; t; t = t->next)
        if (is_in_line(t, tenant->priority) && t->served < start - FAIR_SHARE_CREDIT)
            t->served = start - FAIR_SHARE_CREDIT;
}

void fair_share_look(struct fair_share *share)
{
    for (struct fair_tenant *t = share->first; t; t = t->next) t->seen = t->ahead = 0;
}

void fair_share_fini(struct fair_share *share)
{
    struct fair_tenant *t;
    while ((t = share->first)) {
        share->first = t->next;
        free(t);
    }
    free(share->weights);
    share->weights = NULL;
}
