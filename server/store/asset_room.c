#include "server/store/asset_room.h"

#include "server/store/asset_tables.h"

/* Checks the quota. An asset that the owner has is counted already. Without tokens there is no
 * quota. */
static int check_quota(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                       uint64_t size_bytes)
{
    uint64_t sum = 0;
    if (!room->tenant_bytes || !claim->owner[0]) return 0;
    int error = asset_owners_find(db, claim->owner, &claim->asset);
    if (error != ERR_NOT_FOUND) return error;
    error = asset_owners_sum(db, claim->owner, &sum);
    if (error) return error;
    const bool fits = sum <= room->tenant_bytes && size_bytes <= room->tenant_bytes - sum;
    return fits ? 0 : ERR_QUOTA;
}

int asset_room_keep(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                    uint64_t size_bytes, bool *existed)
{
    const int error = check_quota(db, room, claim, size_bytes);
    return error ? error : asset_owners_add(db, claim->owner, &claim->asset, size_bytes, existed);
}

int asset_room_find(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim)
{
    if (!objects_have(room->objects, &claim->asset, NULL)) return ERR_NOT_FOUND;
    int error = asset_owners_find(db, claim->owner, &claim->asset);
    if (error != ERR_NOT_FOUND || !claim->sees_all) return error;
    error = asset_owners_find_other(db, NULL, &claim->asset);
    if (error != ERR_NOT_FOUND) return error;
    error = asset_removals_find(db, &claim->asset);
    return error == ERR_NOT_FOUND ? 0 : error ? error : ERR_NOT_FOUND;
}
