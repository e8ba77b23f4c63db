/* Serves /v1/session: the user of a request, and signing in and out from a browser. */
#include "server/http/access.h"
#include "server/http/request.h"

#define SET_COOKIE_BYTES 192

static void answer_cookie(struct request *r, const char *set_cookie)
{
    struct MHD_Response *response = response_empty();
    if (response) {
        if (*set_cookie) response_header(response, "Set-Cookie", set_cookie);
        response_header(response, "Cache-Control", "no-store");
    }
    request_answer(r, 204, response);
}

/* Answers {tokens, name, tenant, role}: whether tokens are asked for, and whose this one is; null
 * without one. */
void route_session_get(struct request *r)
{
    const bool asked = r->http->access.path != NULL;
    const struct token *token = access_token_of(r);
    const char *role = token ? role_name(token->role) : asked ? NULL : role_name(ROLE_ADMIN);
    json_t *body =
        json_pack("{s:b, s:s?, s:s?, s:s?}", "tokens", (int)asked, "name",
                  token ? token->name : NULL, "tenant", token ? token->tenant : NULL, "role", role);
    struct MHD_Response *response = response_of_json(body, "application/json");
    json_decref(body);
    if (response) response_header(response, "Cache-Control", "no-store");
    request_answer(r, 200, response);
}

/* Signs in with a token in the header. A session cannot, as it would last for ever. */
void route_session_post(struct request *r)
{
    char set_cookie[SET_COOKIE_BYTES] = "";
    if (r->by_cookie) {
        request_problem(r, PROBLEM_FORBIDDEN, "signing in takes the token itself", NULL);
        return;
    }
    if (r->http->access.path && access_sign_in(r, set_cookie, sizeof set_cookie) != 0)
        request_problem(r, PROBLEM_INTERNAL, "the system gives no random numbers", NULL);
    else
        answer_cookie(r, set_cookie);
}

void route_session_delete(struct request *r)
{
    char set_cookie[SET_COOKIE_BYTES];
    access_sign_out(r, set_cookie, sizeof set_cookie);
    answer_cookie(r, set_cookie);
}
