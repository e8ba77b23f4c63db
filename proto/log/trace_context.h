#pragma once
/* The identifiers of a request, as in W3C Trace Context (Level 1). They connect the log lines of a
 * request with those of its caller.
 *
 * The trace is the caller's, or a new one. The request's own id is that of its span. */
#include <stdbool.h>
#include <stdint.h>

#define TRACE_CONTEXT_ID_BYTES     33 /* 32 hexadecimal digits and the end */
#define TRACE_CONTEXT_SPAN_BYTES   17 /* 16, and the end */
#define TRACE_CONTEXT_PARENT_BYTES 56 /* of a whole traceparent, and the end */
#define TRACE_CONTEXT_TEXT_BYTES   73 /* and of the caller's span behind it */

/* Texts are lower-case hexadecimal, never all zero; request "": there was no request. */
struct trace_context {
    char id[TRACE_CONTEXT_ID_BYTES];
    char request[TRACE_CONTEXT_SPAN_BYTES];
    char parent[TRACE_CONTEXT_SPAN_BYTES]; /* the caller's span; "": the trace begins here */
    bool sampled;                          /* the caller keeps it */
};

/* A source of distinct ids, which are not secret. For one thread. */
struct trace_context_source {
    uint64_t state;
};
void trace_context_source_init(struct trace_context_source *source);

/* Begins a request. `header` is the value of its only traceparent field, any bytes up to a NUL, or
 * NULL. An invalid value counts as none, as the standard demands. */
void trace_context_begin(struct trace_context_source *source, const char *header,
                         struct trace_context *out);

/* Writes the traceparent to be passed on. */
void trace_context_write(const struct trace_context *trace, char out[TRACE_CONTEXT_PARENT_BYTES]);

/* Write and read a text for storage: the traceparent and, after another dash, the caller's span if
 * there is one; "" for no request. trace_context_kept returns false, and a zero trace, for any
 * other text. */
void trace_context_keep(const struct trace_context *trace, char out[TRACE_CONTEXT_TEXT_BYTES]);
bool trace_context_kept(const char *text, struct trace_context *out);
