#pragma once
/* The command line's side of the HTTP contract, over libcurl. Calls block. A client belongs to one
 * thread.
 *
 * Functions return 0 or a negative ERR_ code and fill *fault with what the server said (its problem
 * document's pointer and detail) or why it could not be asked. */
#include <jansson.h>
#include <signal.h>
#include <stdbool.h>

#include "proto/digest.h"
#include "proto/error.h"

struct client;

/* Creates a client. base_url: "http://127.0.0.1:8040", no slash at the end. */
int client_create(const char *base_url, struct client **out);
void client_destroy(struct client **client);

/* Sends `token` with every request from now on, as a bearer token. ERR_MEMORY. */
int client_set_token(struct client *c, const char *token);
/* Trusts the certificates of a file in PEM, borrowed; NULL: those of the system. */
void client_trust(struct client *c, const char *authority);
/* Configures another request (a curl handle) like this client's: trusted certificates, token. */
void client_lend(const struct client *c, void *curl);

/* Ends requests early from now on, with an error, once *stop is not 0 (set by a signal handler). */
void client_stop_on(struct client *c, const volatile sig_atomic_t *stop);

#define CLIENT_BASE_URL "http://127.0.0.1:8040"

/* Returns the server that a command talks to: `option` if given, else SHEARWATER_SERVER, else
 * CLIENT_BASE_URL. The macro is the line of a command's option table that takes `option`. */
const char *client_base_url(const char *option);
#define CLIENT_SERVER_OPTION(url)                                                                  \
    {                                                                                              \
        .name = "server", .letter = 's', .kind = OPTION_TEXT, .value = "URL",                      \
        .text = "the coordinator (default: $SHEARWATER_SERVER, else " CLIENT_BASE_URL ")",         \
        .out = (url)                                                                               \
    }

/* Uploads a file unless the server has it; *digest is its name. */
int client_put_asset(struct client *c, const char *path, struct digest *digest,
                     struct fault *fault);

/* Sends a request for a path ("/v1/jobs"), with `body` as JSON when not NULL. *out is the answer
 * (new reference; JSON null for an empty one). Any status from 400 on is an error. */
int client_json(struct client *c, const char *method, const char *path, const json_t *body,
                json_t **out, struct fault *fault);

/* POSTs `body` as JSON and saves the answer, asked for as `type`, as client_download does. */
int client_post_download(struct client *c, const char *url_path, const json_t *body,
                         const char *type, const char *path, struct fault *fault);

/* Saves an answer's body at `path` (output_file.h), whole or not at all. */
int client_download(struct client *c, const char *url_path, const char *path, struct fault *fault);

/* Follows a job's events until `event` returns false or the stream ends. Reconnects with
 * Last-Event-ID when the link breaks; gives up after ten tries in a row without an event. */
typedef bool (*client_event)(void *ctx, const char *name, const json_t *data);
int client_events(struct client *c, const char *job, client_event event, void *ctx,
                  struct fault *fault);
