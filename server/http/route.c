#include "server/http/route.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/job_id.h"

static const struct route routes[ROUTE_COUNT] = {
#define ROUTE(name, method, path, handler, body, query)                                            \
    [ROUTE_##name] = {METHOD_##method, path, route_##handler, BODY_##body, query},
#include "server/http/route.def"
#undef ROUTE
};

static const char *const method_names[METHOD_COUNT] = {"GET",  "HEAD",  "PUT",
                                                       "POST", "PATCH", "DELETE"};

const struct route *route_of(enum route_id id)
{
    return &routes[id];
}

bool method_from_name(const char *name, enum method *out)
{
    for (int i = 0; i < METHOD_COUNT; i++)
        if (strcmp(name, method_names[i]) == 0) {
            *out = (enum method)i;
            return true;
        }
    return false;
}

const char *method_name(enum method method)
{
    return method_names[method];
}

/* Decimal digits without a leading zero, at most `limit`. */
static bool read_number(const char *text, uint64_t limit, uint64_t *out)
{
    size_t digits = strspn(text, "0123456789");
    if (digits == 0 || digits > 19 || text[digits] || (text[0] == '0' && digits > 1)) return false;
    *out = strtoull(text, NULL, 10);
    return *out <= limit;
}

/* Returns whether the path has this shape. Forms of the parts are checked after. */
static bool has_shape(const char *path, const struct target *t, bool is_file)
{
    if (strcmp(path, "/{file}") == 0) return is_file && t->segment_count > 0;
    size_t i = 0;
    for (const char *at = path + 1; *at; i++) {
        size_t n = strcspn(at, "/");
        if (i == t->segment_count) return false;
        if (*at != '{' && (strlen(t->segment[i]) != n || memcmp(t->segment[i], at, n) != 0))
            return false;
        at += n + (at[n] == '/');
    }
    return i == t->segment_count;
}

static int read_part(const char *name, size_t name_bytes, const char *text, struct route_match *m,
                     struct fault *fault)
{
    uint64_t number = 0;
    if (strncmp(name, "{sha256}", name_bytes) == 0) {
        if (digest_from_hex(text, &m->sha256) != 0)
            return fault_set(fault, ERR_SYNTAX, "",
                             "an asset's name is a SHA-256: 64 lower-case hexadecimal digits");
    } else if (strncmp(name, "{id}", name_bytes) == 0) {
        if (!job_id_is_valid(text))
            return fault_set(fault, ERR_NOT_FOUND, "",
                             "there is no such job: an id has 26 characters of 0-9 and a-z");
        memcpy(m->job, text, sizeof m->job); /* a valid id fills it */
    } else if (strncmp(name, "{n}", name_bytes) == 0) {
        if (!read_number(text, INT32_MAX, &number))
            return fault_set(fault, ERR_NOT_FOUND, "", "there is no such frame: not a number");
        m->frame = (int32_t)number;
    } else if (strncmp(name, "{worker}", name_bytes) == 0) {
        if (!read_number(text, UINT64_MAX, &m->worker))
            return fault_set(fault, ERR_NOT_FOUND, "", "there is no such worker: not a number");
    }
    return 0;
}

static int read_parts(const struct route *route, const struct target *t, struct route_match *m,
                      struct fault *fault)
{
    const char *at = route->path + 1;
    for (size_t i = 0; *at && i < t->segment_count; i++) {
        size_t n = strcspn(at, "/");
        int error = *at == '{' ? read_part(at, n, t->segment[i], m, fault) : 0;
        if (error) return error;
        at += n + (at[n] == '/');
    }
    return 0;
}

static int check_query(const struct route *route, const struct target *t, struct fault *fault)
{
    if (strcmp(route->query, "*") == 0) return 0;
    for (size_t i = 0; i < t->parameter_count; i++) {
        const char *name = t->parameter[i].name;
        char wanted[32];
        int n = snprintf(wanted, sizeof wanted, " %s ", name);
        bool fits = n < (int)sizeof wanted && !strchr(name, ' ');
        if (!fits || !strstr(route->query, wanted))
            return fault_set(fault, ERR_UNKNOWN_MEMBER, "", "unknown query parameter \"%.64s\"",
                             name);
    }
    return 0;
}

static void allow(struct route_match *m, enum method method)
{
    size_t used = strlen(m->allow);
    snprintf(m->allow + used, sizeof m->allow - used, "%s%s%s", used ? ", " : "",
             method_names[method], method == METHOD_GET ? ", HEAD" : "");
}

int route_find(enum method method, bool known_method, const struct target *target, bool is_file,
               struct route_match *m, struct fault *fault)
{
    enum method asked = method == METHOD_HEAD ? METHOD_GET : method;
    *m = (struct route_match){.id = ROUTE_COUNT};
    for (int i = 0; i < ROUTE_COUNT && m->id == ROUTE_COUNT; i++) {
        const struct route *route = &routes[i];
        if (!has_shape(route->path, target, is_file)) continue;
        allow(m, route->method);
        if (known_method && (route->method == method || route->method == asked))
            m->id = (enum route_id)i;
    }
    if (m->id == ROUTE_COUNT)
        return m->allow[0] ? fault_set(fault, ERR_STATE, "", "%s takes %s", target->path, m->allow)
                           : fault_set(fault, ERR_NOT_FOUND, "", "there is nothing at %.200s",
                                       target->path);
    int error = read_parts(&routes[m->id], target, m, fault);
    return error ? error : check_query(&routes[m->id], target, fault);
}
