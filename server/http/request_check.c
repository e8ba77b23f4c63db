#include "server/http/request_check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define HEADER_LIMIT_BYTES 16384u /* of all header fields together */
#define HEADER_LIMIT_COUNT 100

/* The fields that must be seen as they came, however often they are there. */
struct header_scan {
    unsigned fields, hosts, lengths, codings, origins, types, claims;
    size_t size_bytes;
    const char *host, *length, *coding, *origin;
};

static enum MHD_Result scan_field(void *ctx, enum MHD_ValueKind kind, const char *name,
                                  const char *value)
{
    struct header_scan *s = ctx;
    (void)kind;
    value = value ? value : "";
    s->fields++;
    s->size_bytes += strlen(name) + strlen(value) + 4;
    if (strcasecmp(name, "Host") == 0) {
        s->hosts++;
        s->host = value;
    } else if (strcasecmp(name, "Content-Length") == 0) {
        s->lengths++;
        s->length = value;
    } else if (strcasecmp(name, "Transfer-Encoding") == 0) {
        s->codings++;
        s->coding = value;
    } else if (strcasecmp(name, "Origin") == 0) {
        s->origins++;
        s->origin = value;
    } else if (strcasecmp(name, "Content-Type") == 0) {
        s->types++;
    } else if (strcasecmp(name, "Authorization") == 0) {
        s->claims++;
    }
    return MHD_YES;
}

bool request_check_host_is_local(const char *host)
{
    static const char *const names[] = {"localhost", "127.0.0.1", "[::1]"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        size_t n = strlen(names[i]);
        if (strncasecmp(host, names[i], n) != 0) continue;
        if (host[n] == '\0') return true;
        size_t digits = host[n] == ':' ? strspn(host + n + 1, "0123456789") : 0;
        return digits >= 1 && digits <= 5 && host[n + 1 + digits] == '\0';
    }
    return false;
}

/* Two readers that see different bodies in one request can be set against each other (request
 * smuggling), so anything but one clear statement is refused. */
static const char *body_fault(const struct header_scan *s, const char *version,
                              struct body_claim *claim)
{
    *claim = (struct body_claim){.chunked = s->codings > 0};
    if (s->codings > 0 && s->lengths > 0)
        return "Content-Length and Transfer-Encoding exclude each other";
    if (s->codings > 1 || s->lengths > 1) return "the body's length is stated more than once";
    if (s->codings == 1 && strcasecmp(s->coding, "chunked") != 0)
        return "the only transfer coding taken is chunked";
    if (s->codings == 1 && strcmp(version, "HTTP/1.1") != 0)
        return "HTTP/1.0 has no transfer codings";
    if (s->lengths == 1) {
        size_t digits = strspn(s->length, "0123456789");
        if (digits == 0 || digits > 18 || s->length[digits])
            return "Content-Length must be a decimal number";
        claim->size_bytes = strtoull(s->length, NULL, 10);
    }
    claim->present = claim->chunked || claim->size_bytes > 0;
    return NULL;
}

static bool origin_is_ours(const struct request *r, const struct header_scan *s)
{
    const char *scheme = r->http->tls.key ? "https://" : "http://";
    const size_t n = strlen(scheme);
    return s->origins == 1 && strncasecmp(s->origin, scheme, n) == 0 &&
           strcasecmp(s->origin + n, s->host) == 0;
}

/* Over TLS the certificate vouches for the name; without it only names are taken that no page of
 * another site can stand behind. */
static bool host_is_ours(const struct request *r, const char *host)
{
    return r->http->tls.key || request_check_host_is_local(host);
}

static bool changes_state(const struct request *r)
{
    return r->method != METHOD_GET && r->method != METHOD_HEAD;
}

bool request_check(struct request *r, const char *version, struct body_claim *claim)
{
    struct header_scan s = {0};
    char detail[128];
    MHD_get_connection_values(r->mhd, MHD_HEADER_KIND, scan_field, &s);
    const char *fault = body_fault(&s, version, claim);
    if (fault) {
        request_problem(r, PROBLEM_MALFORMED, fault, NULL);
    } else if (s.fields > HEADER_LIMIT_COUNT || s.size_bytes > HEADER_LIMIT_BYTES) {
        snprintf(detail, sizeof detail, "at most %u bytes in %d header fields", HEADER_LIMIT_BYTES,
                 HEADER_LIMIT_COUNT);
        request_problem(r, PROBLEM_HEADERS, detail, NULL);
    } else if (s.hosts != 1 || s.types > 1 || s.claims > 1) {
        request_problem(r, PROBLEM_MALFORMED,
                        "one Host, and at most one Content-Type and Authorization, are taken",
                        NULL);
    } else if (!host_is_ours(r, s.host)) {
        request_problem(r, PROBLEM_MISDIRECTED, "ask for localhost, 127.0.0.1 or [::1]", NULL);
    } else if (changes_state(r) && s.origins > 0 && !origin_is_ours(r, &s)) {
        request_problem(r, PROBLEM_CROSS_ORIGIN,
                        "only the viewer's own pages may change things here", NULL);
    } else {
        return true;
    }
    return false;
}
