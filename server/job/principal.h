#pragma once
/* The user on whose behalf a request acts on jobs, and that request. A job that a user
 * may not see does not exist for them. */
#include <stdbool.h>
#include <string.h>

#include "proto/log/trace_context.h"
#include "server/store/job_store.h"

struct principal {
    char owner[JOB_OWNER_BYTES]; /* the user's tenant, which also owns what they submit; "": none */
    bool sees_all;
    struct trace_context trace; /* of the request; zero: none */
};

static inline bool principal_sees(const struct principal *principal, const char *owner)
{
    return principal->sees_all || strcmp(principal->owner, owner) == 0;
}
