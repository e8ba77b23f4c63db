#pragma once
/* Removes assets that their owners give up. A file goes with its last owner.
 *
 * This runs on the store's thread, between the store's changes: a job that names the asset is there
 * before and forbids the removal, or comes after and is refused. The steps, each durable before the
 * next:
 *
 *   1. one transaction: the owner's row goes, and with it the owner's share of the quota; the file
 *      is noted in `removals`
 *   2. the file goes, if it has no other owner, no job that has not ended names it, nothing holds
 *      it and it is neither a picture nor an import's blob
 *   3. one transaction: imports that read it leave the record, their blobs are noted in turn, and
 *      the file's own note goes
 *
 * The row goes before the file: a file without an owner only takes room, while an owner without a
 * file would be told that it is there. A process that is killed between these leaves the note, and
 * the next start goes on from it. A file that cannot go yet keeps its note, too: passes look at it
 * until it can (removal_timer.h says when).
 *
 * A disk may be too full for step 1. Then a file that need not wait goes first, which makes room.
 * That, and an upload that is cut off, may leave an owner without a file: it is dropped by the next
 * start, and where the file is noted. */
#include "server/store/asset_room.h"

/* Gives the claim's asset up. Returns 0 when its owner has it no more. ERR_NOT_FOUND: the owner
 * does not have it. ERR_STATE: active jobs name it, *users says which. ERR_EXISTS: it is a
 * tenant's, a picture or a blob. ERR_NO_SPACE: the removal could not be put on record, and the file
 * may have gone. ERR_IO, ... */
int asset_removal_run(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                      struct asset_users *users);

/* Ends the removals that were begun before this start, except those that must still wait. */
void asset_removal_resume(sqlite3 *db, const struct asset_room *room);

/* Part of a round over all that is noted. A round begins with zeros, and a pass goes on with what
 * the last one left here. */
#define REMOVAL_PASS_FILES 32
struct removal_pass {
    struct digest after; /* the last that was looked at */
    size_t left;         /* noted still, when the round is over */
    bool is_cut;         /* the round goes on */
    uint64_t took_us;
};
void asset_removal_pass(sqlite3 *db, const struct asset_room *room, struct removal_pass *pass);

/* Checks whether an asset that an import read has gone while it ran, since no job forbids that
 * under a dry run. *gone: one has, and the import's blob is noted, to go when it is not held any
 * more. */
int asset_removal_check_import(sqlite3 *db, const struct asset_room *room,
                               const struct digest *assets, size_t count, const struct digest *blob,
                               bool *gone);
