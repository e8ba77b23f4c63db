#pragma once
/* The worker's log. Its lines (proto/log/log.h) name the worker and, if they are about a lease, the
 * job, so that they can be found beside the coordinator's own. For the loop's thread. */
#include "proto/log/log.h"

struct worker_log {
    struct log log;
    const char *worker; /* its name; borrowed */
};

/* The lease that a line is about. */
struct worker_log_lease {
    const char *job; /* "": unknown */
    const struct trace_context
        *trace; /* of the request that submitted it; its request "": not known */
    uint64_t frame_id;
    uint32_t tile, generation;
};

#define WORKER_LOG_FIELDS_MAX 8 /* of the caller's own */

/* Write one line. A NULL worker_log writes nothing. `trace` is of the job's request; NULL, or an
 * empty request: unknown. */
void worker_log_write(struct worker_log *worker_log, enum log_level level, const char *what,
                      const struct log_field *fields, size_t count);
void worker_log_write_traced(struct worker_log *worker_log, enum log_level level, const char *what,
                             const struct trace_context *trace, const struct log_field *fields,
                             size_t count);
void worker_log_write_lease(struct worker_log *worker_log, enum log_level level, const char *what,
                            const struct worker_log_lease *lease, const char *detail);
