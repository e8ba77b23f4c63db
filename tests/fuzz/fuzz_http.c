// sources: server/http/target.c server/http/route.c server/http/range.c server/http/etag.c
// sources: server/job/job_id.c server/stream/events.c
/* What HTTP brings in before any resource is looked at. Input: "METHOD TARGET", then lines of
 * fields, each with a letter for its name. A path that is taken has one meaning: its parts, written
 * with every byte escaped, are read as the same. Ranges lie in their files, tags that match
 * strongly match weakly, and ids that are taken are those that were given out. */
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/log/trace_context.h"
#include "server/http/etag.h"
#include "server/http/range.h"
#include "server/http/route.h"
#include "server/http/target.h"
#include "server/job/job_id.h"
#include "server/stream/events.h"

#define EPOCH       0x5ea4a7e4u
#define RANGE_BYTES UINT64_C(1000)

/* No request gets as far as its handler here: the table of routes names them all. */
#define HANDLER(name)                                                                              \
    void route_##name(struct request *r)                                                           \
    {                                                                                              \
        (void)r;                                                                                   \
        abort();                                                                                   \
    }
HANDLER(asset_put)
HANDLER(asset_head)
HANDLER(asset_delete)
HANDLER(job_submit)
HANDLER(job_list)
HANDLER(job_get)
HANDLER(job_patch)
HANDLER(job_delete)
HANDLER(image_exr)
HANDLER(image_png)
HANDLER(thumbnail)
HANDLER(events)
HANDLER(pixels)
HANDLER(worker_list)
HANDLER(worker_patch)
HANDLER(stats)
HANDLER(session_get)
HANDLER(session_post)
HANDLER(session_delete)
HANDLER(livez)
HANDLER(readyz)
HANDLER(metrics)
HANDLER(openapi)
HANDLER(static_file)
#undef HANDLER

static void must(bool holds)
{
    if (!holds) abort();
}

static void check_segments(const struct target *t)
{
    must(t->path[0] == '/');
    for (size_t i = 0; i < t->segment_count; i++) {
        const char *s = t->segment[i];
        must(*s && strcmp(s, ".") != 0 && strcmp(s, "..") != 0 && !strpbrk(s, "/\\"));
        for (; *s; s++) must((unsigned char)*s >= 0x20 && *s != 0x7f);
    }
}

/* Escapes every byte; false when that is too long to be read again. */
static bool escape(const struct target *t, char *out)
{
    char *const end = out + LIMIT_HTTP_URL_BYTES;
    *out++ = '/';
    for (size_t i = 0; i < t->segment_count; i++) {
        if (i > 0) *out++ = '/';
        for (const char *s = t->segment[i]; *s; s++) {
            if (end - out < 8) return false;
            out += sprintf(out, "%%%02X", (unsigned char)*s);
        }
    }
    *out = '\0';
    return true;
}

static void read_twice(const struct target *t)
{
    static char text[LIMIT_HTTP_URL_BYTES + 16];
    struct target again;
    struct fault fault = {0};
    if (!escape(t, text)) return;
    must(target_read(text, &again, &fault) == 0);
    must(again.segment_count == t->segment_count && strcmp(again.path, t->path) == 0);
    for (size_t i = 0; i < t->segment_count; i++)
        must(strcmp(again.segment[i], t->segment[i]) == 0);
    target_fini(&again);
}

static void try_route(const char *method_text, const struct target *t)
{
    enum method method = METHOD_GET;
    const bool known = method_from_name(method_text, &method);
    for (int is_file = 0; is_file < 2; is_file++) {
        struct route_match m;
        struct fault fault = {0};
        const int error = route_find(method, known, t, is_file, &m, &fault);
        if (error) {
            must(error < 0 && (error == ERR_NOT_FOUND || fault.detail[0] || m.allow[0]));
            continue;
        }
        must(known && m.id < ROUTE_COUNT && m.frame >= 0);
        must(!m.job[0] || job_id_is_valid(m.job));
    }
}

static void try_request(char *line)
{
    char *target = strchr(line, ' ');
    struct target t;
    struct fault fault = {0};
    if (!target) return;
    *target++ = '\0';
    const int error = target_read(target, &t, &fault);
    if (error) {
        must(error < 0);
        return;
    }
    check_segments(&t);
    read_twice(&t);
    try_route(line, &t);
    (void)target_parameter(&t, "after");
    target_fini(&t);
}

static void try_range(const char *value)
{
    for (uint64_t bytes = 0; bytes <= RANGE_BYTES; bytes += RANGE_BYTES / 2) {
        const struct range r = range_read(value, bytes);
        if (r.kind == RANGE_PART)
            must(r.size_bytes > 0 && r.first_byte < bytes && r.size_bytes <= bytes - r.first_byte);
    }
}

static void try_tags(const char *value)
{
    char tag[ETAG_BYTES];
    etag_of_bytes("picture", 7, tag);
    must(!etag_matches(value, tag) || etag_listed(value, tag));
}

static void try_event_id(const char *value)
{
    char text[48];
    const uint64_t id = event_id_read(EPOCH, value);
    if (id == 0) return;
    snprintf(text, sizeof text, "%08x-%" PRIu64, EPOCH, id);
    must(event_id_read(EPOCH, text) == id);
    must(strncmp(value, text, 9) == 0);
    must(event_id_read(EPOCH + 1, value) == 0);
    struct event_ring ring;
    event_ring_init(&ring, EPOCH);
    must(!event_ring_has_after(&ring, id) && !event_ring_pending(&ring, id));
    event_ring_fini(&ring);
}

static void try_trace(const char *value)
{
    struct trace_context_source source = {1};
    struct trace_context trace, next;
    char text[TRACE_CONTEXT_PARENT_BYTES];
    trace_context_begin(&source, value, &trace);
    must(strlen(trace.id) == 32 && strlen(trace.request) == 16);
    trace_context_write(&trace, text);
    trace_context_begin(&source, text, &next);
    must(strcmp(next.id, trace.id) == 0 && strcmp(next.parent, trace.request) == 0);
}

static void try_line(char *line)
{
    static void (*const fields[])(const char *) = {
        ['R'] = try_range, ['E'] = try_tags, ['L'] = try_event_id, ['T'] = try_trace};
    const unsigned char name = (unsigned char)line[0];
    if (name < sizeof fields / sizeof *fields && fields[name] && line[1] == ':')
        fields[name](line + 2);
    else
        try_request(line);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    while (size_bytes > 0) {
        const uint8_t *end = memchr(data, '\n', size_bytes);
        const size_t bytes = end ? (size_t)(end - data) : size_bytes;
        char *line = malloc(bytes + 1); /* just as long, so that reads beyond it are seen */
        if (!line) return 0;
        memcpy(line, data, bytes);
        line[bytes] = '\0';
        try_line(line);
        free(line);
        data += bytes + (end != NULL);
        size_bytes -= bytes + (end != NULL);
    }
    return 0;
}
