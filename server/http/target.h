#pragma once
/* A request target in origin form, taken apart: "/v1/jobs?limit=5".
 *
 * The path is decoded once. It is refused when another program could read it differently: dot
 * segments, empty segments, encoded slashes, backslashes, control characters. Nothing here touches
 * a file. */
#include <stdbool.h>
#include <stddef.h>

#include "proto/error.h"

#define TARGET_SEGMENTS   8
#define TARGET_PARAMETERS 8

struct target_parameter {
    const char *name, *value; /* lead into the target's text; value "" when there was no "=" */
};

struct target {
    char *text;                           /* owned: what the pointers below lead into */
    const char *segment[TARGET_SEGMENTS]; /* decoded parts of the path between slashes */
    size_t segment_count;                 /* 0 for "/" */
    const char *path;                     /* decoded, with its leading slash */
    struct target_parameter parameter[TARGET_PARAMETERS];
    size_t parameter_count;
};

/* Parses a target into *out, to be freed with target_fini. ERR_LIMIT: longer than
 * LIMIT_HTTP_URL_BYTES; ERR_NOT_FOUND: more segments than any route has; ERR_SYNTAX: anything else,
 * *fault says what; ERR_MEMORY. */
int target_read(const char *raw, struct target *out, struct fault *fault);
void target_fini(struct target *t);

/* Returns the parameter's value, or NULL. */
const char *target_parameter(const struct target *t, const char *name);
