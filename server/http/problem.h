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

/* type, title, status, detail (when not NULL or empty) and pointer (likewise). New reference; NULL
 * on failed allocation. */
json_t *problem_json(enum problem_id id, const char *detail, const char *pointer);

/* What a fault in a document that was sent is: SYNTAX when it could not be read at all,
 * MISSING_ASSET, KEY_REUSED, QUOTA, BUSY, as below for our own troubles, else INVALID. */
enum problem_id problem_of_document(const struct fault *fault);
/* What an ERR_ code of our own troubles is: DISK_FULL, STORAGE, OUT_OF_MEMORY, else INTERNAL. */
enum problem_id problem_of_trouble(int code);
