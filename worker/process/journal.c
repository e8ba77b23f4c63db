#include "worker/process/journal.h"

#include <assert.h>
#include <string.h>

void journal_write_traced(struct journal *journal, enum log_level level, const char *what,
                          const struct trace *trace, const struct log_field *fields, size_t count)
{
    struct log_field all[1 + JOURNAL_FIELDS_MOST];
    if (!journal) return;
    assert(count <= JOURNAL_FIELDS_MOST);
    all[0] = (struct log_field){"worker", journal->worker, 0};
    if (count > 0) memcpy(all + 1, fields, count * sizeof *fields);
    log_write(&journal->log, level, what, trace && trace->request[0] ? trace : NULL, all,
              1 + count);
}

void journal_write(struct journal *journal, enum log_level level, const char *what,
                   const struct log_field *fields, size_t count)
{
    journal_write_traced(journal, level, what, NULL, fields, count);
}

void journal_write_lease(struct journal *journal, enum log_level level, const char *what,
                         const struct journal_lease *lease, const char *detail)
{
    const struct log_field fields[] = {{"job", lease->job, 0},
                                       {"frame_id", NULL, (double)lease->frame_id},
                                       {"tile", NULL, lease->tile},
                                       {"generation", NULL, lease->generation},
                                       {"detail", detail, 0}};
    journal_write_traced(journal, level, what, lease->trace, fields, 5);
}
