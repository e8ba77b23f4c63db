#include "server/http/resource/job_body.h"

#include <stdlib.h>
#include <string.h>

#include "proto/json.h"

void job_body_error(struct request *r, int error)
{
    if (error == ERR_NOT_FOUND)
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such job", NULL);
    else if (error == ERR_STATE)
        request_problem(r, PROBLEM_ENDED, NULL, NULL);
    else
        request_trouble(r, error, error_text(error));
}

int job_body_tag(const json_t *body, char etag[ETAG_BYTES], char **text)
{
    char *compact = json_text(body, JSON_COMPACT);
    if (!compact) return ERR_MEMORY;
    etag_of_bytes(compact, strlen(compact), etag);
    if (text)
        *text = compact;
    else
        free(compact);
    return 0;
}

struct MHD_Response *job_body_tagged(struct request *r, const json_t *body)
{
    char etag[ETAG_BYTES], *text;
    const int error = job_body_tag(body, etag, &text);
    if (error) {
        job_body_error(r, error);
        return NULL;
    }
    if (r->method != METHOD_PATCH && request_unchanged(r, etag)) {
        free(text);
        return NULL;
    }
    struct MHD_Response *response = response_of_taken(text, strlen(text), "application/json");
    if (response) {
        response_header(response, "ETag", etag);
        response_header(response, "Cache-Control", "no-cache");
    } else {
        job_body_error(r, ERR_MEMORY);
    }
    return response;
}

void job_body_send(struct request *r, int error, const json_t *body)
{
    if (error || !body) {
        job_body_error(r, error ? error : ERR_NOT_FOUND);
        return;
    }
    struct MHD_Response *response = job_body_tagged(r, body);
    if (response) request_answer(r, 200, response);
}
