#include "server/http/problem.h"

#include <stdbool.h>
#include <stdio.h>

#include "proto/json.h"

static const struct problem problems[PROBLEM_COUNT] = {
#define PROBLEM(name, status, slug, title) [PROBLEM_##name] = {status, slug, title},
#include "server/http/problem.def"
#undef PROBLEM
};

const struct problem *problem_of(enum problem_id id)
{
    return &problems[id];
}

json_t *problem_json(enum problem_id id, const char *detail, const char *pointer)
{
    const struct problem *p = &problems[id];
    char type[96];
    snprintf(type, sizeof type, "urn:shearwater:problem:%s", p->slug);
    json_t *body = json_object();
    int failed = !body;
    failed |= json_object_set_new(body, "type", json_string(type));
    failed |= json_object_set_new(body, "title", json_string(p->title));
    failed |= json_object_set_new(body, "status", json_integer((json_int_t)p->status));
    if (detail && *detail) failed |= json_object_set_new(body, "detail", json_words(detail));
    if (pointer && *pointer) failed |= json_object_set_new(body, "pointer", json_words(pointer));
    if (failed) {
        json_decref(body);
        return NULL;
    }
    return body;
}

enum problem_id problem_of_document(const struct fault *fault)
{
    bool whole = fault->pointer[0] == '\0';
    switch (fault->code) {
    case ERR_SYNTAX:
    case ERR_TRUNCATED:
    case ERR_TRAILING:
    case ERR_LIMIT:
        return whole ? PROBLEM_SYNTAX : PROBLEM_INVALID;
    case ERR_NOT_FOUND:
        return PROBLEM_MISSING_ASSET;
    case ERR_MISMATCH:
        return whole ? PROBLEM_KEY_REUSED : PROBLEM_INVALID;
    case ERR_QUOTA:
        return PROBLEM_QUOTA;
    case ERR_FULL:
        return PROBLEM_BUSY;
    case ERR_MEMORY:
    case ERR_IO:
    case ERR_NO_SPACE:
        return problem_of_trouble(fault->code);
    case ERR_STATE:
        return PROBLEM_DRAINING;
    default:
        return PROBLEM_INVALID;
    }
}

enum problem_id problem_of_trouble(int code)
{
    switch (code) {
    case ERR_NO_SPACE:
        return PROBLEM_DISK_FULL;
    case ERR_IO:
        return PROBLEM_STORAGE;
    case ERR_MEMORY:
        return PROBLEM_OUT_OF_MEMORY;
    default:
        return PROBLEM_INTERNAL;
    }
}
