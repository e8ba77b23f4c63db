#pragma once
/* Finds the resource that a request means, in one table, route.def. */
#include <stdint.h>

#include "proto/digest.h"
#include "server/http/target.h"
#include "server/store/job_store.h"

struct request;

enum method { METHOD_GET, METHOD_HEAD, METHOD_PUT, METHOD_POST, METHOD_PATCH, METHOD_DELETE };
#define METHOD_COUNT 6

enum route_body { BODY_NONE, BODY_JSON, BODY_FILE };

enum route_id {
#define ROUTE(name, method, path, handler, body, query) ROUTE_##name,
#include "server/http/route.def"
#undef ROUTE
    ROUTE_COUNT
};

struct route {
    enum method method;
    const char *path;
    void (*handle)(struct request *r); /* the request is whole: answer now or later */
    enum route_body body;
    const char *query;
};

/* Handlers of route.def. */
#define ROUTE(name, method, path, handler, body, query) void route_##handler(struct request *r);
#include "server/http/route.def"
#undef ROUTE

/* The checked parts of a path; those that the route's path does not name are zero. */
struct route_match {
    enum route_id id; /* ROUTE_COUNT: no path matches */
    struct digest sha256;
    char job[JOB_ID_BYTES];
    int32_t frame;
    uint64_t worker;
    char allow[64]; /* methods that the path knows, for 405 */
};

const struct route *route_of(enum route_id id);

/* Reads "GET" and so on; false for a method that no route has. */
bool method_from_name(const char *name, enum method *out);
const char *method_name(enum method method);

/* Finds the route of a method and path. is_file: the path is one of the viewer's files. 0;
 * ERR_NOT_FOUND; ERR_STATE when the path exists but not with this method (m->allow is set);
 * ERR_SYNTAX for a malformed digest; ERR_UNKNOWN_MEMBER for an unknown query parameter. *fault says
 * what. known_method false: `method` is ignored and never found. */
int route_find(enum method method, bool known_method, const struct target *target, bool is_file,
               struct route_match *m, struct fault *fault);
