#include <stdio.h>
#include <time.h>

#include "server/cli/client/client.h"
#include "server/cli/client/client_request.h"
#include "server/cli/client/event_parser.h"

#define EVENT_TRIES 10

static size_t feed_events(char *data, size_t size, size_t count, void *ctx)
{
    return event_parser_feed(ctx, data, size * count) ? size * count : 0;
}

/* Follows events until the connection ends. */
static int follow(struct client *c, const char *path, struct event_parser *parser, long *status,
                  struct fault *fault)
{
    char last[64];
    struct curl_slist *headers = curl_slist_append(NULL, "Accept: text/event-stream");
    if (parser->last_id[0]) {
        snprintf(last, sizeof last, "Last-Event-ID: %s", parser->last_id);
        headers = curl_slist_append(headers, last);
    }
    client_begin(c, path);
    curl_easy_setopt(c->curl, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(c->curl, CURLOPT_WRITEFUNCTION, feed_events);
    curl_easy_setopt(c->curl, CURLOPT_WRITEDATA, parser);
    /* The server says something at least every 15 s; a minute of silence is a dead link. */
    curl_easy_setopt(c->curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl_easy_setopt(c->curl, CURLOPT_LOW_SPEED_TIME, 60L);
    int error = client_perform(c, status, fault);
    curl_slist_free_all(headers);
    return error;
}

int client_events(struct client *c, const char *job, client_event event, void *ctx,
                  struct fault *fault)
{
    char path[256];
    struct event_parser parser;
    int error = 0;
    snprintf(path, sizeof path, "/v1/jobs/%s/events", job);
    event_parser_init(&parser, event, ctx);
    for (int tries = 0; tries < EVENT_TRIES && !parser.stopped && !(c->stop && *c->stop); tries++) {
        uint64_t before = parser.events;
        long status = 0;
        event_parser_restart(&parser);
        error = follow(c, path, &parser, &status, fault);
        if (!error && status >= 400) {
            error = fault_set(fault, client_code_of_status(status), "",
                              "events of job %s: HTTP %ld", job, status);
            break;
        }
        if (parser.events > before) tries = -1;
        if (!parser.stopped) nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL);
    }
    if (parser.error)
        error = fault_set(fault, parser.error, "", "events of job %s: %s", job,
                          error_text(parser.error));
    if (parser.stopped) error = 0;
    event_parser_fini(&parser);
    return error;
}
