#pragma once
/* Where assets are, and who has one.
 *
 * An upload is written and synced beside its place, then kept (its owner is on record, durably),
 * then placed. The owner comes before the file, so that no file is there that no row speaks of: a
 * process that is killed between these leaves an owner without a file, to whom it is not there, and
 * the next start drops such owners (asset_removal.h). The file is held (objects.h) from before it
 * is kept until it is placed. */
#include <sqlite3.h>

#include "server/store/job_store.h"

struct asset_room {
    const struct objects *objects;
    uint64_t tenant_bytes; /* that a tenant's assets may have; 0: as many as they will */
};

/* From now on the claim's owner has it. Its bytes are known to be those of the claim. existed: had
 * it before. ERR_QUOTA, ERR_NO_SPACE, ... */
int asset_room_keep(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                    uint64_t size_bytes, bool *existed);

/* Is it there for who claims it? An asset of another tenant is not, but for who sees all; a file
 * that is about to go is for nobody. ERR_NOT_FOUND, ... */
int asset_room_find(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim);
