#include "server/store/job_schema.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <unistd.h>

#include "proto/error.h"

#define BUSY_MS     5000
#define PROBE_BYTES 4096
#define PATH_BYTES  4400

/* Element i leads from version i to i + 1. Append-only: what has been released stays as it is. */
static const char *const migrations[] = {
    "CREATE TABLE jobs ("
    "  id TEXT PRIMARY KEY,"
    "  document TEXT,"
    "  state TEXT NOT NULL,"
    "  error TEXT,"
    "  report TEXT,"
    "  created_ms INTEGER NOT NULL,"
    "  updated_ms INTEGER NOT NULL,"
    "  priority INTEGER NOT NULL);"
    "CREATE INDEX jobs_by_state ON jobs (state, id);"
    "CREATE TABLE frames ("
    "  job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,"
    "  number INTEGER NOT NULL,"
    "  state TEXT NOT NULL,"
    "  exr BLOB,"
    "  png BLOB,"
    "  PRIMARY KEY (job, number)) WITHOUT ROWID;"
    "CREATE TABLE keys ("
    "  key TEXT PRIMARY KEY,"
    "  body BLOB NOT NULL,"
    "  job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE) WITHOUT ROWID;"
    "CREATE INDEX keys_by_job ON keys (job);"
    "CREATE TABLE blobs ("
    "  source BLOB PRIMARY KEY,"
    "  blob BLOB NOT NULL) WITHOUT ROWID;",
    "ALTER TABLE jobs ADD COLUMN paused INTEGER NOT NULL DEFAULT 0;",
    "ALTER TABLE jobs ADD COLUMN owner TEXT NOT NULL DEFAULT '';"
    "CREATE INDEX jobs_by_owner ON jobs (owner, id);"
    "CREATE INDEX jobs_by_owner_state ON jobs (owner, state, id);",
    "ALTER TABLE jobs ADD COLUMN trace TEXT NOT NULL DEFAULT '';",
    "CREATE TABLE blob_assets ("
    "  source BLOB NOT NULL REFERENCES blobs (source) ON DELETE CASCADE,"
    "  asset BLOB NOT NULL,"
    "  PRIMARY KEY (source, asset)) WITHOUT ROWID;"
    "CREATE INDEX blob_assets_by_asset ON blob_assets (asset);"
    "CREATE INDEX blobs_by_blob ON blobs (blob);"
    "CREATE INDEX frames_by_exr ON frames (exr);"
    "CREATE INDEX frames_by_png ON frames (png);",
    "CREATE TABLE asset_owners ("
    "  owner TEXT NOT NULL,"
    "  asset BLOB NOT NULL,"
    "  bytes INTEGER NOT NULL,"
    "  PRIMARY KEY (owner, asset)) WITHOUT ROWID;"
    "CREATE TABLE removals (object BLOB PRIMARY KEY) WITHOUT ROWID;",
    "CREATE TABLE marks ("
    "  job TEXT PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,"
    "  name TEXT,"
    "  labels TEXT) WITHOUT ROWID;",
    "CREATE TABLE thumbnails ("
    "  job TEXT PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,"
    "  png BLOB NOT NULL);",
    "CREATE TABLE webhooks ("
    "  job TEXT PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,"
    "  url TEXT NOT NULL,"
    "  tries INTEGER NOT NULL DEFAULT 0,"
    "  due_ms INTEGER NOT NULL DEFAULT 0) WITHOUT ROWID;",
};
#define VERSION ((int)(sizeof migrations / sizeof migrations[0]))

int job_schema_error(int sqlite_code)
{
    switch (sqlite_code & 0xff) {
    case SQLITE_OK:
    case SQLITE_ROW:
    case SQLITE_DONE:
        return 0;
    case SQLITE_NOMEM:
        return ERR_MEMORY;
    case SQLITE_FULL:
        return ERR_NO_SPACE;
    case SQLITE_CONSTRAINT:
        return ERR_EXISTS;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
        return ERR_CORRUPT;
    default:
        return ERR_IO;
    }
}

static int run(sqlite3 *db, const char *sql)
{
    return job_schema_error(sqlite3_exec(db, sql, NULL, NULL, NULL));
}

static int read_version(sqlite3 *db, int *out)
{
    sqlite3_stmt *s = NULL;
    int code = sqlite3_prepare_v2(db, "PRAGMA user_version", -1, &s, NULL);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    if (code == SQLITE_ROW) *out = sqlite3_column_int(s, 0);
    sqlite3_finalize(s);
    return code == SQLITE_ROW ? 0 : job_schema_error(code == SQLITE_DONE ? SQLITE_CORRUPT : code);
}

/* Migrates by one step. The new version number is written with it or not at all. */
static int migrate_from(sqlite3 *db, int version)
{
    char set[64];
    snprintf(set, sizeof set, "PRAGMA user_version = %d", version + 1);
    int error = run(db, "BEGIN IMMEDIATE");
    if (!error) error = run(db, migrations[version]);
    if (!error) error = run(db, set);
    if (!error) error = run(db, "COMMIT");
    if (error) run(db, "ROLLBACK");
    return error;
}

static int migrate(sqlite3 *db)
{
    int version = 0;
    int error = read_version(db, &version);
    if (!error && (version > VERSION || version < 0)) error = ERR_VERSION;
    while (!error && version < VERSION) error = migrate_from(db, version++);
    return error;
}

int job_schema_open(const char *path, bool ephemeral, sqlite3 **out)
{
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    sqlite3 *db = NULL;
    *out = NULL;
    int error = job_schema_error(sqlite3_open_v2(path, &db, flags, NULL));
    /* What cannot be opened for writing SQLite opens for reading. */
    if (!error && sqlite3_db_readonly(db, "main") != 0) error = ERR_IO;
    if (!error) {
        sqlite3_busy_timeout(db, BUSY_MS);
        error = run(db, ephemeral ? "PRAGMA synchronous = OFF" : "PRAGMA synchronous = FULL");
    }
    if (!error)
        error = run(db, "PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON;"
                        "PRAGMA trusted_schema = OFF");
    if (!error) error = migrate(db);
    if (error) {
        sqlite3_close(db); /* NULL is fine */
        return error;
    }
    *out = db;
    return 0;
}

int job_schema_probe(const char *path)
{
    static const char nothing[PROBE_BYTES];
    char name[PATH_BYTES];
    if (snprintf(name, sizeof name, "%s-probe", path) >= (int)sizeof name) return ERR_LIMIT;
    const int fd = open(name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    const bool works =
        fd >= 0 && write(fd, nothing, sizeof nothing) == sizeof nothing && !fsync(fd);
    const int error = works ? 0 : errno == ENOSPC ? ERR_NO_SPACE : ERR_IO;
    if (fd >= 0) {
        close(fd);
        unlink(name);
    }
    return error;
}
