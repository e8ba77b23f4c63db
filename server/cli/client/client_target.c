#include "server/cli/client/client_target.h"

#include <gnutls/gnutls.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/secret_file.h"
#include "server/access/tokens.h"

#define TOKEN_FILE_BYTES 1024u

static const char *from_environment(const char *option, const char *name)
{
    const char *text = option ? option : getenv(name);
    return text && *text ? text : NULL;
}

/* Returns whether the host of "http://HOST:PORT" is one for which no packet leaves this machine. */
static bool stays_here(const char *url)
{
    static const char *const names[] = {"localhost", "127.0.0.1", "[::1]"};
    if (strncmp(url, "http://", 7) != 0) return strncmp(url, "https://", 8) == 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const size_t n = strlen(names[i]);
        if (strncmp(url + 7, names[i], n) != 0) continue;
        const char *after = url + 7 + n;
        if (*after == ':') after += 1 + strspn(after + 1, "0123456789");
        if (*after == '/' || *after == '\0') return true; /* and no "@HOST" */
    }
    return false;
}

/* `text` may end with a newline, as files do. */
static int give_token(struct client *c, const char *url, const char *text, const char *from,
                      struct fault *fault)
{
    char token[TOKEN_FILE_BYTES + 1];
    const size_t n = strcspn(text, "\r\n");
    if (n > TOKEN_FILE_BYTES || text[n + strspn(text + n, "\r\n")] || !tokens_is_text(text, n))
        return fault_set(fault, ERR_SYNTAX, from,
                         "is no token: 20 to 256 letters, digits and -._~+/=");
    if (!stays_here(url))
        return fault_set(fault, ERR_STATE, from,
                         "the token would go to %.100s in the clear: use an https address", url);
    memcpy(token, text, n);
    token[n] = '\0';
    int error = client_set_token(c, token);
    gnutls_memset(token, 0, sizeof token);
    return error ? fault_set(fault, error, "", "%s", error_text(error)) : 0;
}

static int give_token_of_file(struct client *c, const char *url, const char *path,
                              struct fault *fault)
{
    char *text = NULL;
    size_t size_bytes = 0;
    int error =
        secret_file_read(path, SECRET_READERS_GROUP, TOKEN_FILE_BYTES, &text, &size_bytes, fault);
    if (!error) error = give_token(c, url, text, path, fault);
    if (text) gnutls_memset(text, 0, size_bytes);
    free(text);
    return error;
}

int client_target_open(const struct client_target *target, struct client **out, struct fault *fault)
{
    const char *url = client_base_url(target->server), *token = getenv("SHEARWATER_TOKEN");
    const char *file = from_environment(target->token_file, "SHEARWATER_TOKEN_FILE");
    struct client *c = NULL;
    int error = client_create(url, &c);
    if (error) return fault_set(fault, error, "", "%s", error_text(error));
    client_trust(c, from_environment(target->authority, "SHEARWATER_CA"));
    if (file)
        error = give_token_of_file(c, url, file, fault);
    else if (token && *token)
        error = give_token(c, url, token, "SHEARWATER_TOKEN", fault);
    if (error)
        client_destroy(&c);
    else
        *out = c;
    return error;
}
