#pragma once
/* Whose a request is, and whether he may. Two ways to say who one is: a token in the header
 * Authorization, as programs do; or the cookie that POST /v1/session gives for one, as browsers do,
 * whose EventSource can send no header. The cookie is HttpOnly and SameSite=Strict, and with it
 * only requests change things whose Origin is ours: no other page can use it. Nothing of either is
 * ever in a URL or a log.
 *
 * Without a file of tokens everybody may do everything, and the server listens on loopback only. */
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
    char cookie[ACCESS_COOKIE_BYTES]; /* its name: cookies do not tell ports apart, so it does */
    bool secure;                      /* the cookie goes over TLS alone */
};

/* *fault says what is wrong with the file. */
int access_open(struct access *a, const char *tokens_path, bool secure, struct fault *fault);
void access_close(struct access *a);
/* The cookie's name, once the port is known. */
void access_name_cookie(struct access *a, int port);

/* Reads the file again; on failure the tokens from before stay. */
int access_reload(struct access *a, struct fault *fault);

enum role access_role_of(enum route_id route);

/* Finds out whose the request is, which notes it down; true when he may have what the route has,
 * else the request has its answer (401, 403). */
bool access_pass(struct request *r);

/* Is what was allowed when the request came allowed now? */
bool access_still_holds(const struct request *r);
/* The part of it that changes by itself: does the sign-in hold that it came by, if it came by one?
 */
bool access_sign_in_holds(const struct request *r);

/* The request's token, or NULL: without tokens, and on routes for everybody. */
const struct token *access_token_of(const struct request *r);

/* For the header Set-Cookie: signs in with the request's token, or, with `sign_out`, takes the
 * browser's cookie back. ERR_IO. */
int access_sign_in(struct request *r, char *set_cookie, size_t capacity);
void access_sign_out(struct request *r, char *set_cookie, size_t capacity);
