#pragma once
/* A request in the log, and the ids by which it is found there. */
struct request;

/* Its head is there: gives it its ids, from the caller's traceparent if that is valid. */
void request_log_begin(struct request *r);

/* Its answer is about to be queued: puts the ids into its header. */
void request_log_answer(struct request *r);

/* It is over: one line. Of what is asked all the time (probes, metrics, the viewer's files) only
 * what went wrong. */
void request_log_end(const struct request *r);
