#pragma once
/* Internals of a client, for its own files alone: client.c makes requests, client_events.c follows
 * a job's events. */
#include <curl/curl.h>
#include <signal.h>

#include "proto/error.h"

struct client {
    CURL *curl;
    char base_url[512];
    char message[CURL_ERROR_SIZE];
    const volatile sig_atomic_t *stop; /* NULL: none */
    char *token;                       /* owned; NULL: none */
    const char *authority;             /* NULL: the system's */
};

/* Begins a fresh request on the kept connection. */
void client_begin(struct client *c, const char *path);

/* Runs the prepared request; *status is set when 0 is returned. */
int client_perform(struct client *c, long *status, struct fault *fault);

/* Returns the ERR_ code for an HTTP status from 400 on. */
int client_code_of_status(long status);
