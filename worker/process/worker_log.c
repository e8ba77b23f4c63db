#include "worker/process/worker_log.h"

#include <assert.h>
#include <string.h>

void worker_log_write_traced(struct worker_log *worker_log, enum log_level level, const char *what,
                             const struct trace_context *trace, const struct log_field *fields,
                             size_t count)
{
    struct log_field all[1 + WORKER_LOG_FIELDS_MAX];
    if (!worker_log) return;
    assert(count <= WORKER_LOG_FIELDS_MAX);
    all[0] = (struct log_field){"worker", worker_log->worker, 0};
    if (count > 0) memcpy(all + 1, fields, count * sizeof *fields);
    log_write(&worker_log->log, level, what, trace && trace->request[0] ? trace : NULL, all,
              1 + count);
}

void worker_log_write(struct worker_log *worker_log, enum log_level level, const char *what,
                      const struct log_field *fields, size_t count)
{
    worker_log_write_traced(worker_log, level, what, NULL, fields, count);
}

void worker_log_write_lease(struct worker_log *worker_log, enum log_level level, const char *what,
                            const struct worker_log_lease *lease, const char *detail)
{
    const struct log_field fields[] = {{"job", lease->job, 0},
                                       {"frame_id", NULL, (double)lease->frame_id},
                                       {"tile", NULL, lease->tile},
                                       {"generation", NULL, lease->generation},
                                       {"detail", detail, 0}};
    worker_log_write_traced(worker_log, level, what, lease->trace, fields, 5);
}
