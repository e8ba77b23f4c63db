#include "server/webhook/webhook_hosts.h"

#include <ctype.h>
#include <curl/curl.h>
#include <stdlib.h>
#include <string.h>

#define POINTER "/webhook/url"

/* Reads a host and maybe a port of `length` bytes. */
static bool read_host(const char *text, size_t length, struct webhook_host *out)
{
    const bool bracketed = length > 2 && text[0] == '[';
    const char *bracket = bracketed ? memchr(text, ']', length) : NULL;
    const char *colon = bracketed ? bracket ? bracket + 1 : NULL : memchr(text, ':', length);
    const char *end = text + length;
    if (bracketed && !bracket) return false;
    if (!colon || colon == end) colon = NULL;
    const char *from = bracketed ? text + 1 : text, *to = bracketed ? bracket : colon ? colon : end;
    *out = (struct webhook_host){0};
    if (to == from || (size_t)(to - from) >= sizeof out->name) return false;
    for (const char *c = from; c < to; c++) {
        if (*c <= ' ' || *c > '~' || strchr("/@?#*", *c)) return false;
        out->name[c - from] = (char)tolower((unsigned char)*c);
    }
    if (!colon) return true;
    char *rest;
    const long port =
        *colon == ':' && isdigit((unsigned char)colon[1]) ? strtol(colon + 1, &rest, 10) : 0;
    if (port < 1 || port > 65535 || rest != end) return false;
    out->port = (uint16_t)port;
    return true;
}

int webhook_hosts_read(const char *list, struct webhook_hosts *out, struct fault *fault)
{
    out->count = 0;
    for (const char *at = list, *end; at; at = *end ? end + 1 : NULL) {
        end = strchrnul(at, ',');
        if (out->count == WEBHOOK_HOSTS_MAX)
            return fault_set(fault, ERR_LIMIT, "--webhook-hosts", "more than %d hosts",
                             WEBHOOK_HOSTS_MAX);
        if (!read_host(at, (size_t)(end - at), &out->hosts[out->count++]))
            return fault_set(fault, ERR_SYNTAX, "--webhook-hosts",
                             "\"%.*s\" is no HOST or HOST:PORT", (int)(end - at), at);
    }
    return 0;
}

struct address {
    char name[256];
    long port;
    bool is_usual; /* the port of its scheme */
};

static bool get_part(CURLU *url, CURLUPart part, char *out, size_t capacity)
{
    char *text = NULL;
    if (curl_url_get(url, part, &text, part == CURLUPART_PORT ? CURLU_DEFAULT_PORT : 0))
        return false;
    const size_t length = strlen(text);
    const bool fits = length < capacity;
    if (fits) memcpy(out, text, length + 1);
    curl_free(text);
    return fits;
}

static int read_address(CURLU *parsed, const char *url, struct address *out, struct fault *fault)
{
    char scheme[16], port[8];
    if (curl_url_set(parsed, CURLUPART_URL, url, 0) ||
        !get_part(parsed, CURLUPART_SCHEME, scheme, sizeof scheme) ||
        !get_part(parsed, CURLUPART_HOST, out->name, sizeof out->name) ||
        !get_part(parsed, CURLUPART_PORT, port, sizeof port))
        return fault_set(fault, ERR_SYNTAX, POINTER, "it is no URL");
    char *text = NULL;
    if (curl_url_get(parsed, CURLUPART_USER, &text, 0) == CURLUE_OK) {
        curl_free(text);
        return fault_set(fault, ERR_UNSUPPORTED, POINTER,
                         "it names a user; the signature tells who calls");
    }
    const size_t length = strlen(out->name);
    if (out->name[0] == '[') { /* without brackets */
        memmove(out->name, out->name + 1, length - 2);
        out->name[length - 2] = '\0';
    }
    for (char *c = out->name; *c; c++) *c = (char)tolower((unsigned char)*c);
    out->port = strtol(port, NULL, 10);
    out->is_usual = out->port == (strcmp(scheme, "https") == 0 ? 443 : 80);
    return 0;
}

int webhook_hosts_check(const struct webhook_hosts *hosts, const char *url, struct fault *fault)
{
    struct address a = {{0}, 0, false};
    if (!hosts)
        return fault_set(fault, ERR_UNSUPPORTED, POINTER,
                         "this server tells nobody: its operator allows no --webhook-hosts");
    CURLU *parsed = curl_url();
    int error = parsed ? read_address(parsed, url, &a, fault)
                       : fault_set(fault, ERR_MEMORY, POINTER, "memory is exhausted");
    curl_url_cleanup(parsed);
    for (size_t i = 0; !error && i < hosts->count; i++) {
        const struct webhook_host *h = &hosts->hosts[i];
        if (strcmp(h->name, a.name) == 0 && (h->port ? h->port == a.port : a.is_usual)) return 0;
    }
    if (error) return error;
    return fault_set(fault, ERR_UNSUPPORTED, POINTER,
                     "%.200s:%ld is none of the hosts that this server's operator allows", a.name,
                     a.port);
}
