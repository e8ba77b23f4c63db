#pragma once
/* The place of assets, and their owners.
 *
 * An upload is written and synced beside its place, then kept (its owner is on record, durably),
 * then placed. The owner comes before the file, so that every file has a row. A process that is
 * killed between the two leaves an owner without a file, for whom the asset is missing. The next
 * start drops such owners (asset_removal.h). The file is held (objects.h) from before it is kept
 * until it is placed. */
#include <sqlite3.h>

#include "server/store/job_store.h"

struct asset_room {
    const struct objects *objects;
    uint64_t tenant_bytes; /* that a tenant's assets may have; 0: unlimited */
};

/* Gives the asset to the claim's owner. Its bytes are known to be those of the claim. existed: the
 * owner had it before. ERR_QUOTA, ERR_NO_SPACE, ... */
int asset_room_keep(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                    uint64_t size_bytes, bool *existed);

/* Returns 0 if the asset exists for the claim. An asset of another tenant exists only for users who
 * see all, and a file that is about to go does not exist. ERR_NOT_FOUND, ... */
int asset_room_find(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim);
