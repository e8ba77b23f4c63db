#pragma once
/* Who brought which asset: whoever knows a digest does not yet have the file.
 *
 *   DIR/owners/TENANT/ab/cdef...   an empty file for each asset that the tenant has uploaded
 *
 * Plain blocking calls without shared state, for any thread, as objects.h. */
#include "server/store/objects.h"

/* Durable with 0; existed: it was there. ERR_IO, ERR_LIMIT; also for an owner that is no tenant's
 * name (job_store.h). */
int asset_owners_add(const struct objects *o, const char *owner, const struct digest *d,
                     bool *existed);
/* Durable with 0. ERR_NOT_FOUND when it was not there. */
int asset_owners_remove(const struct objects *o, const char *owner, const struct digest *d);
bool asset_owners_have(const struct objects *o, const char *owner, const struct digest *d);
/* Has anybody? True, too, when that cannot be found out. */
bool asset_owners_any(const struct objects *o, const struct digest *d);
/* Bytes of all that the owner has, whoever else has it. ERR_IO, ERR_LIMIT. */
int asset_owners_sum(const struct objects *o, const char *owner, uint64_t *bytes);

/* 1 to 64 of a-z, 0-9, '-' and '_': safe in a path, in a header and beside an idempotency key. */
bool asset_owners_is_name(const char *owner);
