#include "server/store/asset_usage.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/asset_owners.h"
#include "server/store/job_store.h"

struct tenant_usage {
    struct tenant_usage *next;
    uint64_t bytes;
    char owner[JOB_OWNER_BYTES];
};

struct asset_usage {
    const struct objects *objects;
    uint64_t most_bytes;
    pthread_mutex_t lock; /* over what follows */
    struct tenant_usage *first;
};

int asset_usage_create(const struct objects *objects, uint64_t most_bytes, struct asset_usage **out)
{
    struct asset_usage *usage = calloc(1, sizeof *usage);
    if (!usage) return ERR_MEMORY;
    usage->objects = objects;
    usage->most_bytes = most_bytes;
    pthread_mutex_init(&usage->lock, NULL);
    *out = usage;
    return 0;
}

void asset_usage_destroy(struct asset_usage **usage_)
{
    struct asset_usage *usage = *usage_;
    struct tenant_usage *one;
    *usage_ = NULL;
    if (!usage) return;
    while ((one = usage->first)) {
        usage->first = one->next;
        free(one);
    }
    pthread_mutex_destroy(&usage->lock);
    free(usage);
}

static int find(struct asset_usage *usage, const char *owner, struct tenant_usage **out)
{
    struct tenant_usage *one = usage->first;
    while (one && strcmp(one->owner, owner) != 0) one = one->next;
    *out = one;
    if (one) return 0;
    if (!asset_owners_is_name(owner)) return ERR_LIMIT;
    if (!(one = calloc(1, sizeof *one))) return ERR_MEMORY;
    const int error = asset_owners_sum(usage->objects, owner, &one->bytes);
    if (error) {
        free(one);
        return error;
    }
    memcpy(one->owner, owner, strlen(owner) + 1);
    one->next = usage->first;
    *out = usage->first = one;
    return 0;
}

int asset_usage_learn(struct asset_usage *usage, const char *owner)
{
    struct tenant_usage *one;
    pthread_mutex_lock(&usage->lock);
    const int error = find(usage, owner, &one);
    pthread_mutex_unlock(&usage->lock);
    return error;
}

int asset_usage_take(struct asset_usage *usage, const char *owner, uint64_t size_bytes)
{
    struct tenant_usage *one;
    pthread_mutex_lock(&usage->lock);
    int error = find(usage, owner, &one);
    if (!error && (one->bytes > usage->most_bytes || size_bytes > usage->most_bytes - one->bytes))
        error = ERR_QUOTA;
    if (!error) one->bytes += size_bytes;
    pthread_mutex_unlock(&usage->lock);
    return error;
}

void asset_usage_give(struct asset_usage *usage, const char *owner, uint64_t size_bytes)
{
    struct tenant_usage *one;
    pthread_mutex_lock(&usage->lock);
    if (find(usage, owner, &one) == 0)
        one->bytes -= size_bytes < one->bytes ? size_bytes : one->bytes;
    pthread_mutex_unlock(&usage->lock);
}
