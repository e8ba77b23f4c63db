#pragma once
/* A job as an answer: its document with its tag, or why there is none. */
#include "server/http/etag.h"
#include "server/http/request.h"

/* Answers with an error of the store or the jobs, for requests that sent no document. */
void job_body_error(struct request *r, int error);

/* Computes the tag of a job's document and, unless NULL, its text, which the caller frees.
 * ERR_MEMORY. */
int job_body_tag(const json_t *body, char etag[ETAG_BYTES], char **text);

/* Returns a document with its tag. NULL: it was answered, as unchanged or with a problem. */
struct MHD_Response *job_body_tagged(struct request *r, const json_t *body);

/* Answers 200 with the document and its tag, or 304 where the client has it; with an error, or
 * without a document, the problem. */
void job_body_send(struct request *r, int error, const json_t *body);
