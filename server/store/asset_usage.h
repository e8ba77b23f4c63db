#pragma once
/* How many bytes of assets each tenant has brought, and how many he may: for a quota.
 *
 * The figures are those of asset_owners.h, summed once for each tenant when he first brings
 * something, then kept here. Any thread; calls block, the first of a tenant for as long as it takes
 * to go through his assets. */
#include "server/store/objects.h"

struct asset_usage;

/* objects is borrowed. ERR_MEMORY. */
int asset_usage_create(const struct objects *objects, uint64_t most_bytes,
                       struct asset_usage **out);
void asset_usage_destroy(struct asset_usage **usage);

/* Sums what the tenant has, if that is not known yet: before his marks change, so that each change
 * counts once. ERR_MEMORY, ERR_IO, ERR_LIMIT. */
int asset_usage_learn(struct asset_usage *usage, const char *owner);
/* Counts one more before it is kept: ERR_QUOTA when it does not fit, ERR_MEMORY, ERR_IO. */
int asset_usage_take(struct asset_usage *usage, const char *owner, uint64_t size_bytes);
/* It was not kept, or was his already, or is his no more. */
void asset_usage_give(struct asset_usage *usage, const char *owner, uint64_t size_bytes);
