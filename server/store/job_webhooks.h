#pragma once
/* Jobs whose end is to be told, in a table beside the jobs. A row comes with its job. It is pending
 * once the job has ended, and goes when it is over, or with the job. */
#include <sqlite3.h>

#include "server/store/job_store.h"

int job_webhooks_add(sqlite3 *db, const char *id, const char *url);
int job_webhooks_note(sqlite3 *db, const char *id, uint32_t tries, int64_t due_ms);
/* *rows is malloc'ed: WEBHOOKS_READ at most, those that are due first. */
int job_webhooks_list(sqlite3 *db, struct webhook_row **rows, size_t *count);
