#pragma once
/* Authenticates requests and checks what they may do. A client names its user by a token in the
 * header Authorization, as programs do, or by the cookie that POST /v1/session gives for a token,
 * as browsers do, whose EventSource can send no header. The cookie is HttpOnly and SameSite=Strict,
 * and a request with it changes things only when its Origin is ours, so no other page can use it.
 * Neither is ever in a URL or a log.
 *
 * Without a file of tokens all clients may do everything, and the server listens on loopback only.
 */
#include <stdbool.h>

#include "server/access/sign_ins.h"
#include "server/access/tokens.h"
#include "server/http/route.h"

struct request;

#define ACCESS_COOKIE_BYTES 32

struct access {
    const char *path; /* borrowed; NULL: no tokens are asked for */
    struct tokens *tokens;
    struct sign_ins *sign_ins;
    char cookie[ACCESS_COOKIE_BYTES]; /* its name, which contains the port, since cookies do not
                                         tell ports apart */
    bool secure;                      /* the cookie goes over TLS alone */
};

/* Reads the file of tokens. *fault says what is wrong with it. */
int access_open(struct access *a, const char *tokens_path, bool secure, struct fault *fault);
void access_close(struct access *a);
/* Sets the cookie's name, once the port is known. */
void access_name_cookie(struct access *a, int port);

/* Reads the file again; on failure the tokens from before stay. */
int access_reload(struct access *a, struct fault *fault);

enum role access_role_of(enum route_id route);

/* Finds the request's user and notes it in the request. Returns true when that user may use the
 * route; else the request has its answer (401, 403). */
bool access_pass(struct request *r);

/* Returns whether the request would still be allowed now. */
bool access_still_holds(const struct request *r);
/* Returns whether the sign-in that the request came by still holds, or it came by none: the part
 * that changes by itself. */
bool access_sign_in_holds(const struct request *r);

/* Returns the request's token; NULL without tokens, and on routes that need none. */
const struct token *access_token_of(const struct request *r);

/* Signs in with the request's token, and writes the header Set-Cookie; ERR_IO. access_sign_out
 * takes the browser's cookie back. */
int access_sign_in(struct request *r, char *set_cookie, size_t capacity);
void access_sign_out(struct request *r, char *set_cookie, size_t capacity);
