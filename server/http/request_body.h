#pragma once
/* The body of a request. The head is checked first. Then the bytes go where they belong as they
 * come: a document into memory, a file to the disk. */
#include "server/http/request.h"

struct body_claim; /* request_check.h */

/* Checks the head. False: the request has its answer. */
bool request_body_check(struct request *r, const struct body_claim *claim);

/* Takes some of the bytes that have come. *size_bytes becomes what is left, which MHD passes again.
 * MHD_NO: the connection ends. */
enum MHD_Result request_body_take(struct request *r, const char *data, size_t *size_bytes);

/* Lets the connection wait for the disk. No deadline of the client runs meanwhile, since the delay
 * is not its fault. request_body_wake ends that, and does nothing to a connection that does not
 * sleep. */
void request_body_sleep(struct request *r);
void request_body_wake(struct request *r);

/* Answers that the body could not be kept: an ERR_ code. */
void request_body_refuse(struct request *r, int error);
