#pragma once
/* Parses Server-Sent Events from a byte stream (WHATWG HTML, section 9.2.6), with data as JSON. */
#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct event_parser {
    /* false: stop. data is NULL where it is no JSON. */
    bool (*event)(void *ctx, const char *name, const json_t *data);
    void *ctx;
    char *line; /* owned; the unfinished line */
    size_t line_bytes, line_capacity;
    char *data; /* owned; data lines of the unfinished event */
    size_t data_bytes, data_capacity;
    char name[64], id[40]; /* of the unfinished event */
    char last_id[40];      /* of the last whole one */
    uint64_t events;
    bool stopped; /* by the callback */
    int error;    /* of what was fed last: ERR_MEMORY, ERR_LIMIT; the event has not been seen */
};

void event_parser_init(struct event_parser *p,
                       bool (*event)(void *ctx, const char *name, const json_t *data), void *ctx);
void event_parser_fini(struct event_parser *p);

/* Begins a new connection: forgets the unfinished event, but keeps the last id. */
void event_parser_restart(struct event_parser *p);

/* Parses bytes. False when it was stopped, and with an error: memory is exhausted or an event is
 * above 16 MiB. */
bool event_parser_feed(struct event_parser *p, const char *bytes, size_t size_bytes);
