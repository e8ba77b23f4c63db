#pragma once
/* A request in the log, and the ids by which it is found there. */
struct request;

/* Gives a request whose head is there its ids, from the caller's traceparent if that is valid. */
void request_log_begin(struct request *r);

/* Puts the ids into the header of an answer that is about to be queued. */
void request_log_answer(struct request *r);

/* Writes one line for a request that is over. Frequent requests (probes, metrics, the viewer's
 * files) are logged only when they went wrong. */
void request_log_end(const struct request *r);
