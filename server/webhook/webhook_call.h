#pragma once
/* One call of a webhook: its body, its signature, its answer. */
#include <curl/curl.h>
#include <stdbool.h>

#include "proto/link/link_key.h"
#include "server/store/job_store.h"

struct webhook_call {
    struct webhook_row row;
    CURL *curl;                 /* owned */
    struct curl_slist *headers; /* owned */
    char *body;                 /* owned */
    size_t answer_bytes;        /* that have come */
};

/* Makes a call that is not yet begun, with the time now. NULL without memory. */
struct webhook_call *webhook_call_create(const struct webhook_row *row, const struct link_key *key,
                                         long answer_ms);
/* Frees and nulls; NULL is ignored. */
void webhook_call_destroy(struct webhook_call **call);

/* Returns whether it was answered 2xx; else `failure` says what happened. */
bool webhook_call_succeeded(const struct webhook_call *call, CURLcode result, char failure[256]);
