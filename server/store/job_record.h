#pragma once
/* Jobs as read from the database: copies that outlive the query. */
#include <sqlite3.h>

#include "server/store/job_store.h"

/* Columns of `jobs`, and all columns in the order that job_records_add reads. */
#define JOB_RECORD_OWN_COLUMNS                                                                     \
    "id, document, state, error, report, created_ms, updated_ms, priority, paused, owner, trace"
#define JOB_RECORD_COLUMNS                                                                         \
    JOB_RECORD_OWN_COLUMNS ", (SELECT name FROM marks WHERE job = id),"                            \
                           " (SELECT labels FROM marks WHERE job = id),"                           \
                           " (SELECT png FROM frames WHERE job = id AND png NOT NULL"              \
                           " ORDER BY number DESC LIMIT 1)"
#define JOB_RECORD_FRAME_COLUMNS "number, state, exr, png"

struct job_record {
    struct job_row row;       /* texts owned */
    struct frame_row *frames; /* owned; their states are static text */
    size_t frame_count, frame_capacity;
};

struct job_records {
    struct job_record *items; /* owned */
    size_t count, capacity;
    bool more;
};

/* Append the statement's current row. After ERR_MEMORY, too, fini frees what is there. */
int job_records_add(struct job_records *out, sqlite3_stmt *s);
int job_record_add_frame(struct job_record *job, sqlite3_stmt *s);
void job_records_fini(struct job_records *records);

/* Read single columns. False, and a zero digest, for NULL and for a wrong size. */
bool job_record_digest(sqlite3_stmt *s, int column, struct digest *out);
void job_record_id(sqlite3_stmt *s, int column, char out[JOB_ID_BYTES]);
