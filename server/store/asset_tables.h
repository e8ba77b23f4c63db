#pragma once
/* What the database says about stored files. Calls block, and are for the store's thread; they are
 * rare, so that no statement is kept prepared. Errors are those of job_schema_error.
 *
 *   asset_owners   the owners of each asset, and its size; the owner is "" without tokens
 *   removals       files that may have no owner, or may be missing. Each is checked until it is
 *                  gone, or exists and has an owner
 *
 * Changes are made inside the caller's transaction, or else each is one of its own. */
#include <sqlite3.h>

#include "server/store/job_store.h"

int asset_tables_begin(sqlite3 *db);
/* Ends a transaction. With 0 all changes since asset_tables_begin are durable, with an error none.
 */
int asset_tables_end(sqlite3 *db, int error);

/* Adds an owner. existed: the owner had it before. */
int asset_owners_add(sqlite3 *db, const char *owner, const struct digest *asset,
                     uint64_t size_bytes, bool *existed);
/* Drops an owner; NULL: all of them. */
int asset_owners_drop(sqlite3 *db, const char *owner, const struct digest *asset);
/* Returns 0, ERR_NOT_FOUND when the owner does not have it, or an error that leaves it unknown. */
int asset_owners_find(sqlite3 *db, const char *owner, const struct digest *asset);
/* Looks for an owner other than that one; NULL: for any owner. */
int asset_owners_find_other(sqlite3 *db, const char *owner, const struct digest *asset);
int asset_owners_sum(sqlite3 *db, const char *owner, uint64_t *size_bytes);

int asset_removals_add(sqlite3 *db, const struct digest *object);
int asset_removals_drop(sqlite3 *db, const struct digest *object);
int asset_removals_find(sqlite3 *db, const struct digest *object);
int asset_removals_count(sqlite3 *db, size_t *count);

/* Finds jobs of the owner (NULL: of all) that have not ended and name the asset, oldest first. */
int asset_users_find(sqlite3 *db, const char *owner, const struct digest *asset,
                     struct asset_users *out);
/* Returns whether the object is a job's picture or the result of an import. It also returns true
 * when that cannot be found out. */
bool asset_is_derived(sqlite3 *db, const struct digest *object);

/* Puts the assets that an import read on record. */
int asset_imports_add(sqlite3 *db, const struct digest *source, const struct digest *assets,
                      size_t count);
/* Takes imports that read the asset off the record. Their blobs may have no owner then. */
int asset_imports_drop(sqlite3 *db, const struct digest *asset);

struct digest_list {
    struct digest *items; /* owned */
    size_t count;
};
/* Append to *out, whose items stay in any case. ERR_MEMORY, too. */
int asset_list_owned(sqlite3 *db, struct digest_list *out);
int asset_list_blobs(sqlite3 *db, const struct digest *asset, struct digest_list *out);
/* Lists at most `limit` removals behind `after` (NULL: from the first), in order. */
int asset_list_removals(sqlite3 *db, const struct digest *after, size_t limit,
                        struct digest_list *out);
