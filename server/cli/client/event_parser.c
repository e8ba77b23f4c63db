#include "server/cli/client/event_parser.h"

#include <stdlib.h>
#include <string.h>

#include "proto/json.h"

#define EVENT_LIMIT_BYTES (16u << 20)

void event_parser_init(struct event_parser *p,
                       bool (*event)(void *ctx, const char *name, const json_t *data), void *ctx)
{
    *p = (struct event_parser){.event = event, .ctx = ctx};
}

void event_parser_fini(struct event_parser *p)
{
    free(p->line);
    free(p->data);
    p->line = p->data = NULL;
}

void event_parser_restart(struct event_parser *p)
{
    p->line_bytes = p->data_bytes = 0;
    p->name[0] = '\0';
    p->error = 0;
    memcpy(p->id, p->last_id, sizeof p->id);
}

static int append(char **buffer, size_t *size_bytes, size_t *capacity, const char *more,
                  size_t more_bytes)
{
    size_t need = *size_bytes + more_bytes + 1;
    if (need > EVENT_LIMIT_BYTES) return ERR_LIMIT;
    if (need > *capacity) {
        size_t grown = need * 2;
        char *fresh = realloc(*buffer, grown);
        if (!fresh) return ERR_MEMORY;
        *buffer = fresh;
        *capacity = grown;
    }
    memcpy(*buffer + *size_bytes, more, more_bytes);
    *size_bytes += more_bytes;
    (*buffer)[*size_bytes] = '\0';
    return 0;
}

static void copy_field(char *out, size_t capacity, const char *value)
{
    size_t n = strnlen(value, capacity - 1);
    memcpy(out, value, n);
    out[n] = '\0';
}

static void call_back(struct event_parser *p)
{
    json_t *data;
    p->error = json_read_foreign(p->data, p->data_bytes, &data);
    if (p->error == ERR_MEMORY) return;
    p->error = 0;
    p->events++;
    p->stopped = !p->event(p->ctx, p->name[0] ? p->name : "message", data);
    json_decref(data);
}

/* The blank line that ends an event, which is seen from now on. */
static void dispatch(struct event_parser *p)
{
    if (p->data_bytes > 0) call_back(p);
    if (p->error) return;
    memcpy(p->last_id, p->id, sizeof p->last_id);
    p->data_bytes = 0;
    p->name[0] = '\0';
}

static void take_data(struct event_parser *p, const char *value)
{
    if (p->data_bytes > 0) p->error = append(&p->data, &p->data_bytes, &p->data_capacity, "\n", 1);
    if (!p->error)
        p->error = append(&p->data, &p->data_bytes, &p->data_capacity, value, strlen(value));
}

static void take_line(struct event_parser *p)
{
    if (p->line_bytes == 0) {
        dispatch(p);
        return;
    }
    char *line = p->line, *colon = strchr(line, ':');
    if (colon == line) return; /* a comment */
    const char *value = colon ? colon + 1 : line + p->line_bytes;
    if (colon) *colon = '\0';
    if (*value == ' ') value++;
    if (strcmp(line, "event") == 0)
        copy_field(p->name, sizeof p->name, value);
    else if (strcmp(line, "id") == 0)
        copy_field(p->id, sizeof p->id, value);
    else if (strcmp(line, "data") == 0)
        take_data(p, value);
}

bool event_parser_feed(struct event_parser *p, const char *bytes, size_t size_bytes)
{
    const char *end = bytes + size_bytes;
    while (bytes < end && !p->stopped) {
        const char *newline = memchr(bytes, '\n', (size_t)(end - bytes));
        const char *stop = newline ? newline : end;
        p->error =
            append(&p->line, &p->line_bytes, &p->line_capacity, bytes, (size_t)(stop - bytes));
        if (p->error) return false;
        bytes = newline ? newline + 1 : end;
        if (!newline) break;
        if (p->line_bytes > 0 && p->line[p->line_bytes - 1] == '\r')
            p->line[--p->line_bytes] = '\0';
        take_line(p);
        if (p->error) return false;
        p->line_bytes = 0;
        p->line[0] = '\0';
    }
    return !p->stopped;
}
