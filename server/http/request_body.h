#pragma once
/* The body of a request: whether its head promises one that is taken, and then its bytes, as they
 * come: a document into memory, a file to the disk. */
#include "server/http/request.h"

struct body_claim; /* request_check.h */

/* By what the head says. False: the request has its answer. */
bool request_body_check(struct request *r, const struct body_claim *claim);

/* Takes what has come, or a part of it: *size_bytes becomes what is left, and comes again. MHD_NO:
 * the connection ends. */
enum MHD_Result request_body_take(struct request *r, const char *data, size_t *size_bytes);

/* The connection waits for the disk, which is no fault of the client's: no deadline of his runs.
 * request_body_wake ends that; it does nothing to one that does not sleep. */
void request_body_sleep(struct request *r);
void request_body_wake(struct request *r);

/* Answers that the body could not be kept: an ERR_ code. */
void request_body_refuse(struct request *r, int error);
