#include "server/http/tenants.h"

#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "server/http/request.h"
#include "server/job/fair_share.h"

int tenants_share(struct http *http, struct fault *fault)
{
    const struct tokens *tokens = http->access.tokens;
    if (!tokens) return 0;
    struct fair_weights *weights =
        calloc(1, sizeof *weights + tokens->count * sizeof weights->list[0]);
    if (!weights)
        return fault_set(fault, ERR_MEMORY, "/tenants",
                         "memory is exhausted: no place for the weights of %zu tokens; those from "
                         "before stay",
                         tokens->count);
    for (size_t i = 0; i < tokens->count; i++) {
        if (tokens->list[i].weight == 1) continue;
        struct fair_weight *w = &weights->list[weights->count++];
        memcpy(w->owner, tokens->list[i].tenant, sizeof w->owner);
        w->weight = tokens->list[i].weight;
    }
    jobs_set_weights(http->options.jobs, weights);
    return 0;
}

static void cut_unwelcome(struct http *http)
{
    for (struct request *r = http->requests; r; r = r->next)
        if (!access_still_holds(r)) (void)shutdown(r->connection->fd, SHUT_RDWR);
}

int http_reload_tokens(struct http *http, size_t *count, struct fault *fault)
{
    int error = access_reload(&http->access, fault);
    if (!error) cut_unwelcome(http);
    if (!error) error = tenants_share(http, fault);
    *count = http->access.tokens ? http->access.tokens->count : 0;
    return error;
}
