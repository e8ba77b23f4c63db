#pragma once
/* Errors as application/problem+json (RFC 9457): one table, problem.def. */
#include <jansson.h>

#include "proto/error.h"

enum problem_id {
#define PROBLEM(name, status, slug, title) PROBLEM_##name,
#include "server/http/problem.def"
#undef PROBLEM
    PROBLEM_COUNT
};

struct problem {
    unsigned status;
    const char *slug, *title;
};

const struct problem *problem_of(enum problem_id id);

/* Writes type, title, status, detail (when not NULL or empty) and pointer (likewise). New
 * reference; NULL on failed allocation. */
json_t *problem_json(enum problem_id id, const char *detail, const char *pointer);

/* Returns the problem for a fault in a document that was sent: SYNTAX when it could not be read at
 * all, MISSING_ASSET, KEY_REUSED, QUOTA, BUSY, that of problem_of_trouble for our own troubles,
 * else INVALID. */
enum problem_id problem_of_document(const struct fault *fault);
/* Returns the problem for an ERR_ code of our own: DISK_FULL, STORAGE, OUT_OF_MEMORY, else
 * INTERNAL. */
enum problem_id problem_of_trouble(int code);
