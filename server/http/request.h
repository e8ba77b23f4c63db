#pragma once
/* One request from its first line to the end of its answer.
 *
 * A request is checked, its body taken in, and then handled. A handler answers at once, or holds
 * the request (the connection is suspended) and answers from a callback. A pending request outlives
 * its connection: the callback asks request_back first. */
#include <jansson.h>
#include <stdbool.h>

#include "server/http/access.h"
#include "server/http/daemon.h"
#include "server/http/problem.h"
#include "server/http/response.h"
#include "server/http/route.h"
#include "server/http/upload.h"
#include "server/job/principal.h"

struct request {
    struct http *http; /* NULL: the connection is gone */
    struct http *home; /* the same, for as long as it is held */
    struct request *next, **link;
    struct MHD_Connection *mhd;
    struct connection *connection;
    struct target target;
    struct fault target_fault; /* of reading it */
    struct route_match match;
    enum method method;
    /* Its user (access.h). */
    struct principal principal;
    struct digest token; /* its hash; zero without one */
    bool has_token;
    bool by_cookie;             /* and not by a header */
    struct sign_in_ref sign_in; /* then: by which */
    struct trace_context trace; /* its id, and the caller's; begun with its head */
    bool checked;               /* its head was looked at */
    bool close;                 /* its body, if any, is not read: the connection cannot go on */
    bool handled;               /* its handler was called */
    bool pending;               /* a callback will come */
    bool overdue;   /* the callback is too late: it was answered meanwhile (pending.h) */
    bool suspended; /* its connection sleeps */
    bool streams;   /* its answer has no end in sight */
    bool opens;     /* it waits for its file to be created, before its body is read */
    bool encodes;   /* and in http->encodings */
    /* The body. */
    char *body;                         /* owned; collected when the route's body is JSON */
    size_t body_bytes, body_room_bytes; /* what has come, what is allocated */
    struct upload *upload;              /* owned; when it is a FILE */
    uint64_t file_bytes;
    uint64_t file_from_ms; /* loop clock when it began, without the time asleep */
    uint64_t asleep_ms;    /* since when it waits for the disk; 0: it does not */
    int body_error;        /* of keeping the body */
    /* The answer. */
    struct MHD_Response *response; /* owned until it is queued */
    unsigned status;
    uint64_t start_us;
    uint64_t handled_ms;    /* loop clock when its handler was called */
    char job[JOB_ID_BYTES]; /* which it submitted; else "" */
};

/* Creates a request. raw: the request target as it came. NULL on failed allocation. */
struct request *request_create(struct http *http, struct connection *connection,
                               struct MHD_Connection *mhd, const char *raw);

/* Serves MHD's access handler. */
enum MHD_Result request_step(struct request *r, const char *method, const char *version,
                             const char *data, size_t *size_bytes);

/* Ends a request that MHD is done with. It is freed now, or by request_back. */
void request_done(struct request *r);

/* Answers the request. The response is taken; NULL becomes an internal error. */
void request_answer(struct request *r, unsigned status, struct MHD_Response *response);
void request_json(struct request *r, unsigned status, json_t *body); /* takes the reference */
void request_ok(struct request *r); /* {status: "ok"}, not to be kept */
void request_problem(struct request *r, enum problem_id id, const char *detail,
                     const char *pointer);
/* Answers that the server itself failed, with an ERR_ code. A failure that may pass (a full disk)
 * is named. */
void request_trouble(struct request *r, int code, const char *detail);
/* Answers with a fault of the document in the body. */
void request_fault(struct request *r, const struct fault *fault);

/* Holds the request before an operation that calls back. The callback calls request_back first.
 * That returns false (and the request may be freed) when no answer is needed any more: its
 * connection is gone, or it has waited for too long (pending.h). */
void request_hold(struct request *r);
bool request_back(struct request *r);

const char *request_header(const struct request *r, const char *name);
bool request_is_head(const struct request *r);
/* Reads a parameter that is "1" or "true", or "0" or "false" or missing. Returns false, and sends a
 * problem, for other values. */
bool request_flag(struct request *r, const char *name, bool *out);

/* Answers 304 and returns true if the client has this version; else returns false. */
bool request_unchanged(struct request *r, const char *etag);
