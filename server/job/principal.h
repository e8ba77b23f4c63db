#pragma once
/* For whom, and by which request, something of the jobs is asked: what one may not see is not there
 * for him. */
#include <stdbool.h>
#include <string.h>

#include "proto/log/trace.h"
#include "server/store/job_store.h"

struct principal {
    char owner[JOB_OWNER_BYTES]; /* whose jobs are his, and whose his own will be; "": nobody's */
    bool sees_all;
    struct trace trace; /* of the request; zero: none */
};

static inline bool principal_sees(const struct principal *principal, const char *owner)
{
    return principal->sees_all || strcmp(principal->owner, owner) == 0;
}
