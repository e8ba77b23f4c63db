#pragma once
/* The server that a command talks to, and the token that it uses. */
#include "server/cli/client/client.h"

struct client_target {
    const char *server;     /* NULL: SHEARWATER_SERVER, else CLIENT_BASE_URL */
    const char *token_file; /* NULL: SHEARWATER_TOKEN_FILE; without both SHEARWATER_TOKEN */
    const char *authority;  /* file; NULL: SHEARWATER_CA, else the system's */
};

/* The lines of a command's option table. */
#define CLIENT_TARGET_OPTIONS(target)                                                              \
    CLIENT_SERVER_OPTION(&(target)->server),                                                       \
        {.name = "token-file",                                                                     \
         .kind = OPTION_TEXT,                                                                      \
         .value = "FILE",                                                                          \
         .text = "file with the access token (default: $SHEARWATER_TOKEN_FILE, else the token "    \
                 "in $SHEARWATER_TOKEN)",                                                          \
         .out = &(target)->token_file},                                                            \
    {                                                                                              \
        .name = "ca", .kind = OPTION_TEXT, .value = "FILE.pem",                                    \
        .text = "certificate authorities that are trusted (default: $SHEARWATER_CA, else the "     \
                "system's)",                                                                       \
        .out = &(target)->authority                                                                \
    }

/* Creates a client that sends the token with every request. ERR_STATE: the token would go over the
 * network in the clear. *fault names what cannot be read. */
int client_target_open(const struct client_target *target, struct client **out,
                       struct fault *fault);
