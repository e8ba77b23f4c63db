#pragma once
/* Which request something belongs to: identifiers as in W3C Trace Context (Level 1), so that lines
 * here can be found from the caller's side and the other way round.
 *
 * The trace is the caller's, or a new one; the request's own id is that of its span. */
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

/* Gives ids that differ; not secret. For one thread. */
struct trace_context_source {
    uint64_t state;
};
void trace_context_source_init(struct trace_context_source *source);

/* A new request. `header`: the value of its only traceparent field, any bytes up to a NUL, or NULL.
 * One that is not valid is as none, as the standard wants it. */
void trace_context_begin(struct trace_context_source *source, const char *header,
                         struct trace_context *out);

/* The traceparent for whoever is told of this request. */
void trace_context_write(const struct trace_context *trace, char out[TRACE_CONTEXT_PARENT_BYTES]);

/* To be kept: the traceparent and, after another dash, the caller's span if there is one; "" for no
 * request. Reading is false, and the trace zero, for all else. */
void trace_context_keep(const struct trace_context *trace, char out[TRACE_CONTEXT_TEXT_BYTES]);
bool trace_context_kept(const char *text, struct trace_context *out);
