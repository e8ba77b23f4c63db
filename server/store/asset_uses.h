#pragma once
/* What in the database refers to stored objects. Blocking, on the store's thread; asked for seldom,
 * so nothing is kept prepared. Errors as job_schema_error. */
#include <sqlite3.h>

#include "server/store/job_store.h"

/* Jobs that have not ended and name the asset, of the owner (NULL: of whoever), oldest first. */
int asset_uses_jobs(sqlite3 *db, const char *owner, const struct digest *asset,
                    struct asset_users *out);

/* Is it a job's picture, or what an import gave? True, too, when that cannot be found out. */
bool asset_uses_is_derived(sqlite3 *db, const struct digest *object);

/* Of an import that is on record: the assets that it read. */
int asset_uses_note_import(sqlite3 *db, const struct digest *source, const struct digest *assets,
                           size_t count);

/* The blobs of all imports that read the asset, and all assets that imports on record have read.
 * each may call nothing here. */
typedef int (*asset_uses_found)(void *ctx, const struct digest *d);
int asset_uses_each_blob(sqlite3 *db, const struct digest *asset, asset_uses_found each, void *ctx);
int asset_uses_each_read(sqlite3 *db, asset_uses_found each, void *ctx);

/* Takes these imports off the record. */
int asset_uses_forget_imports(sqlite3 *db, const struct digest *asset);
