#pragma once
/* An asset is given up by who brought it, and goes with the last who did.
 *
 * On the store's thread, between the store's changes: a job that names the asset is there before
 * and forbids it, or comes after and is refused. The steps, each durable before the next:
 *
 *   1. a note (removal_notes.h) that the file may be nobody's now
 *   2. the owner's mark (asset_owners.h) goes, and with it his share of the quota
 *   3. the file goes, if nobody else has a mark, no job that has not ended names it, and it is no
 *      picture and no import's blob
 *   4. imports that read it leave the record, and their blobs go if nothing else has them
 *   5. the note goes
 *
 * The mark goes before the file: a file without a mark only takes room, while a mark without a file
 * would tell its owner that it is there. Whoever dies between leaves the note, and the next start
 * goes on from it (asset_removal_resume). A file that is held, or beside one that is
 * (object_holds.h), or still named by a job of somebody else keeps its note, too: passes look at it
 * until it can go (asset_removal_pass; removal_timer.h says when).
 *
 * Where a full disk has no room for the note, what must wait is not given up; what need not goes
 * without one, and imports of it that the record cannot forget then wait for the next start. */
#include <sqlite3.h>

#include "server/store/asset_usage.h"
#include "server/store/job_store.h"

struct asset_room {
    const struct objects *objects;
    struct asset_usage *usage; /* NULL: no quota */
};

/* 0 when the asker has it no more. ERR_NOT_FOUND: he has none. ERR_STATE: jobs that have not ended
 * name it, *users says which. ERR_EXISTS: it is nobody's, but to others it is something. ERR_FULL:
 * it, or a file beside it, is held, and no mark of anybody would say that it has been given up.
 * ERR_NO_SPACE: it must wait, and there is no room for its note. ERR_IO, ... */
int asset_removal_run(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                      struct asset_users *users);

/* At start: ends what was begun, but for what must still wait. */
void asset_removal_resume(sqlite3 *db, const struct asset_room *room);

/* Part of a round over all notes, which begins with zeros and goes on with what the last pass left
 * here. */
struct removal_pass {
    struct digest after; /* the last that was looked at */
    size_t left;         /* notes, when the round is over */
    bool is_cut;         /* the round goes on: a pass ends with the first note beyond 20 ms */
    uint64_t took_us;
};
void asset_removal_pass(sqlite3 *db, const struct asset_room *room, struct removal_pass *pass);

/* What an import read may have gone while it ran: a dry run has no job that forbids it. Then its
 * blob is nobody's: ERR_NOT_FOUND, and it is noted, to go when it is not held any more. ERR_IO,
 * ... */
int asset_removal_check_import(sqlite3 *db, const struct asset_room *room,
                               const struct digest *assets, size_t count,
                               const struct digest *blob);
