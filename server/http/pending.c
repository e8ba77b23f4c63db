#include "server/http/pending.h"

#include "server/http/request.h"

#define SYNCED_BYTES_PER_MS 4096u /* by a slow disk */

/* Returns whether one more may wait: as many as there may be connections, each of which waits for
 * one answer at a time. Only requests that were answered as overdue can fill more. */
bool pending_has_room(const struct http *http)
{
    return http->pending.count < LIMIT_HTTP_CONNECTIONS;
}

/* Returns how long a request may wait. It is longer for a body that goes to disk, an import or a
 * picture. */
static uint64_t patience_ms(const struct request *r)
{
    const bool dry = r->match.id == ROUTE_JOB_SUBMIT && target_parameter(&r->target, "dry_run");
    uint64_t ms = r->http->pending.answer_ms + r->file_bytes / SYNCED_BYTES_PER_MS;
    return dry || r->encodes ? ms + LIMIT_IMPORT_MS : ms;
}

static void tell(struct request *r)
{
    const bool keyed = r->match.id == ROUTE_JOB_SUBMIT && request_header(r, "Idempotency-Key");
    r->http->pending.overdue++;
    r->overdue = true;
    request_problem(
        r, PROBLEM_OVERDUE,
        keyed
            ? "it may still be done: sent again with the same Idempotency-Key it is done only once"
            : "it may still be done, or not at all",
        NULL);
}

void pending_tick(struct http *http)
{
    const uint64_t now_ms = uv_now(http->options.loop);
    for (struct request *r = http->requests; r; r = r->next)
        if (r->suspended && r->pending && now_ms - r->handled_ms >= patience_ms(r)) tell(r);
}
