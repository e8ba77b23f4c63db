#pragma once
/* Decides whether a worker may join: its samples must be the same bytes as every other worker's. A
 * refusal says what to do about it. */
#include <stdbool.h>

#include "proto/link/message.h"

struct admission {
    const char *build_id, *isa; /* the coordinator's */
    const char *embree_version; /* the first worker's; "" before it */
    unsigned workers;           /* that have joined */
};

/* Returns false when it is refused; *refused has the code and the advice. */
bool admission_check(const struct admission *a, const struct message_hello *h,
                     struct message_refused *refused);

/* Refuses a HELLO that could not be decoded: with message_decode_hello's error, or ERR_LIMIT if it
 * is too large to be read. */
void admission_refuse_greeting(int error, struct message_refused *refused);
