#include "server/http/access.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "server/http/request.h"

/* A route that has no line is 0 here, and raised to an administrator's below. */
static const struct {
    bool known;
    enum role role;
} needed[ROUTE_COUNT] = {
#define ACCESS(name, role) [ROUTE_##name] = {true, ROLE_##role},
#include "server/http/access.def"
#undef ACCESS
};

enum role access_role_of(enum route_id route)
{
    return route < ROUTE_COUNT && needed[route].known ? needed[route].role : ROLE_ADMIN;
}

/* ---- the table ---- */

/* Seconds; from the environment, so that tests need not wait for the real ones. */
static uint64_t sign_in_hold_s(void)
{
    const char *text = getenv("SHEARWATER_SIGN_IN_S");
    const uint64_t asked = text ? strtoull(text, NULL, 10) : 0;
    return asked >= 1 && asked < SIGN_IN_S ? asked : SIGN_IN_S;
}

int access_open(struct access *a, const char *tokens_path, bool secure, struct fault *fault)
{
    *a = (struct access){.path = tokens_path, .secure = secure};
    if (!tokens_path) return 0;
    int error = tokens_read(tokens_path, &a->tokens, fault);
    if (error) return error;
    a->sign_ins = malloc(sizeof *a->sign_ins);
    if (!a->sign_ins) {
        access_close(a);
        return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    }
    sign_ins_init(a->sign_ins, sign_in_hold_s());
    return 0;
}

void access_close(struct access *a)
{
    free(a->tokens);
    free(a->sign_ins);
    *a = (struct access){0};
}

void access_name_cookie(struct access *a, int port)
{
    snprintf(a->cookie, sizeof a->cookie, "shearwater-%d", port);
}

static bool is_known(void *ctx, const struct digest *token)
{
    const struct access *a = ctx;
    return tokens_find_hash(a->tokens, token) != NULL;
}

int access_reload(struct access *a, struct fault *fault)
{
    struct tokens *fresh = NULL;
    if (!a->path) return fault_set(fault, ERR_STATE, "", "the server was started without --tokens");
    int error = tokens_read(a->path, &fresh, fault);
    if (error) return error;
    free(a->tokens);
    a->tokens = fresh;
    sign_ins_sweep(a->sign_ins, is_known, a);
    return 0;
}

/* ---- one request ---- */

static uint64_t now_s(const struct request *r)
{
    return uv_now(r->http->options.loop) / 1000;
}

/* "Bearer" and the token of an Authorization field, or NULL. */
static const struct token *of_header(const struct access *a, const char *field)
{
    if (strncasecmp(field, "Bearer", 6) != 0 || field[6] != ' ') return NULL;
    field += 6 + strspn(field + 6, " ");
    return tokens_find(a->tokens, field, strlen(field));
}

static const char *cookie_of(const struct request *r)
{
    return MHD_lookup_connection_value(r->mhd, MHD_COOKIE_KIND, r->http->access.cookie);
}

/* A field that is there and wrong is not made good by a cookie. */
static const struct token *identify(struct request *r, bool *claimed)
{
    const struct access *a = &r->http->access;
    const char *field = request_header(r, "Authorization"), *cookie = cookie_of(r);
    *claimed = field || cookie;
    if (field) return of_header(a, field);
    const struct digest *hash =
        cookie ? sign_ins_find(a->sign_ins, cookie, now_s(r), &r->sign_in) : NULL;
    r->by_cookie = hash != NULL;
    return hash ? tokens_find_hash(a->tokens, hash) : NULL;
}

static void note(struct request *r, const struct token *token)
{
    r->has_token = true;
    r->token = token->hash;
    memcpy(r->principal.owner, token->tenant, sizeof r->principal.owner);
    r->principal.sees_all = token->role == ROLE_ADMIN;
}

static void refuse_stranger(struct request *r, bool claimed)
{
    request_problem(r, PROBLEM_UNAUTHENTICATED,
                    claimed ? "the token or the session is not valid, or no longer is"
                            : "send a token: Authorization: Bearer TOKEN",
                    NULL);
    response_header(r->response, "WWW-Authenticate",
                    claimed ? "Bearer realm=\"shearwater\", error=\"invalid_token\""
                            : "Bearer realm=\"shearwater\"");
}

static void refuse_role(struct request *r, const struct token *token, enum role wanted)
{
    char detail[128];
    snprintf(detail, sizeof detail, "this takes the role %s, and the token has %s",
             role_name(wanted), role_name(token->role));
    request_problem(r, PROBLEM_FORBIDDEN, detail, NULL);
}

/* Returns whether another page forged the request. Browsers name the page that sends a request
 * which changes something; a client that does not is no browser and needs no cookie.
 * request_check.c checks the name. */
static bool is_forged(const struct request *r)
{
    return r->by_cookie && r->method != METHOD_GET && r->method != METHOD_HEAD &&
           !request_header(r, "Origin");
}

bool access_pass(struct request *r)
{
    const enum role wanted = access_role_of(r->match.id);
    bool claimed = false;
    if (!r->http->access.path) {
        r->principal.sees_all = true;
        return true;
    }
    const struct token *token = identify(r, &claimed);
    if (token) note(r, token);
    if (wanted == ROLE_NONE) return true;
    if (!token)
        refuse_stranger(r, claimed);
    else if (token->role < wanted)
        refuse_role(r, token, wanted);
    else if (is_forged(r))
        request_problem(r, PROBLEM_CROSS_ORIGIN, "with a cookie, Origin must be there", NULL);
    else
        return true;
    return false;
}

const struct token *access_token_of(const struct request *r)
{
    return r->has_token ? tokens_find_hash(r->http->access.tokens, &r->token) : NULL;
}

bool access_sign_in_holds(const struct request *r)
{
    return !r->by_cookie || sign_ins_holds(r->http->access.sign_ins, &r->sign_in, now_s(r));
}

bool access_still_holds(const struct request *r)
{
    const enum role wanted = access_role_of(r->match.id);
    if (!r->has_token || wanted == ROLE_NONE) return true;
    if (!access_sign_in_holds(r)) return false;
    const struct token *token = access_token_of(r);
    return token && token->role >= wanted && strcmp(token->tenant, r->principal.owner) == 0 &&
           (token->role == ROLE_ADMIN) == r->principal.sees_all;
}

/* ---- browsers ---- */

static void write_cookie(const struct access *a, const char *value, long most_s, char *out,
                         size_t capacity)
{
    snprintf(out, capacity, "%s=%s; Path=/; Max-Age=%ld; HttpOnly; SameSite=Strict%s", a->cookie,
             value, most_s, a->secure ? "; Secure" : "");
}

int access_sign_in(struct request *r, char *set_cookie, size_t capacity)
{
    struct access *a = &r->http->access;
    const char *before = cookie_of(r);
    char cookie[SIGN_IN_TEXT_BYTES];
    int error = sign_ins_add(a->sign_ins, &r->token, now_s(r), cookie);
    if (error) return error;
    if (before) sign_ins_remove(a->sign_ins, before); /* the browser forgets it */
    write_cookie(a, cookie, (long)a->sign_ins->hold_s, set_cookie, capacity);
    return 0;
}

void access_sign_out(struct request *r, char *set_cookie, size_t capacity)
{
    struct access *a = &r->http->access;
    const char *cookie = cookie_of(r);
    if (cookie && a->sign_ins) sign_ins_remove(a->sign_ins, cookie);
    write_cookie(a, "", 0, set_cookie, capacity);
}
