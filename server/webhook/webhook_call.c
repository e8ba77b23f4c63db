#include "server/webhook/webhook_call.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/digest.h"
#include "proto/json.h"
#include "proto/runtime/build.h"
#include "proto/runtime/clock.h"

#define ANSWER_BYTES_MAX 65536u /* nobody reads it */

static char *make_body(const struct webhook_row *row)
{
    json_t *body =
        json_pack("{s:s, s:s?, s:s, s:{s:o, s:o, s:o}}", "id", row->id, "name",
                  row->name[0] ? row->name : NULL, "state", row->state, "links", "job",
                  json_sprintf("/v1/jobs/%s", row->id), "page", json_sprintf("/#/jobs/%s", row->id),
                  "thumbnail", json_sprintf("/v1/jobs/%s/thumbnail", row->id));
    char *text = json_text(body, JSON_COMPACT);
    json_decref(body);
    return text;
}

/* "sha256=" and the digits; false without memory. */
static bool sign(const struct link_key *key, const char *timestamp, const char *body,
                 char out[DIGEST_HEX_BYTES])
{
    struct digest digest;
    gnutls_hmac_hd_t mac;
    if (gnutls_hmac_init(&mac, GNUTLS_MAC_SHA256, key->bytes, sizeof key->bytes) != 0) return false;
    const bool done = gnutls_hmac(mac, timestamp, strlen(timestamp)) == 0 &&
                      gnutls_hmac(mac, ".", 1) == 0 && gnutls_hmac(mac, body, strlen(body)) == 0;
    gnutls_hmac_deinit(mac, digest.bytes);
    digest_to_hex(&digest, out);
    return done;
}

static bool add_header(struct webhook_call *c, const char *name, const char *value)
{
    char line[256];
    snprintf(line, sizeof line, "%s: %s", name, value);
    struct curl_slist *grown = curl_slist_append(c->headers, line);
    if (grown) c->headers = grown;
    return grown != NULL;
}

static bool add_headers(struct webhook_call *c, const struct link_key *key)
{
    char timestamp[24], hex[DIGEST_HEX_BYTES], signature[8 + DIGEST_HEX_BYTES];
    snprintf(timestamp, sizeof timestamp, "%llu",
             (unsigned long long)(clock_us(CLOCK_REALTIME) / 1000000));
    if (!sign(key, timestamp, c->body, hex)) return false;
    snprintf(signature, sizeof signature, "sha256=%s", hex);
    return add_header(c, "Content-Type", "application/json") && add_header(c, "Expect", "") &&
           add_header(c, "Shearwater-Timestamp", timestamp) &&
           add_header(c, "Shearwater-Signature", signature);
}

/* Drops the answer, of which the status alone counts. */
static size_t on_answer(char *data, size_t size, size_t count, void *ctx)
{
    struct webhook_call *c = ctx;
    (void)data;
    c->answer_bytes += size * count;
    return c->answer_bytes <= ANSWER_BYTES_MAX ? size * count : 0;
}

/* No proxy, no redirect and no file of passwords leads it elsewhere. */
static bool set_up(struct webhook_call *c, long answer_ms)
{
    char agent[128];
    CURL *curl = c->curl;
    snprintf(agent, sizeof agent, "shearwater/%.100s", build_id());
    CURLcode code = curl_easy_setopt(curl, CURLOPT_URL, c->row.url);
    code |= curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    code |= curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
    code |= curl_easy_setopt(curl, CURLOPT_PROXY, "");
    code |= curl_easy_setopt(curl, CURLOPT_NETRC, (long)CURL_NETRC_IGNORED);
    code |= curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    code |= curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, answer_ms);
    code |= curl_easy_setopt(curl, CURLOPT_FRESH_CONNECT, 1L);
    code |= curl_easy_setopt(curl, CURLOPT_FORBID_REUSE, 1L);
    code |= curl_easy_setopt(curl, CURLOPT_USERAGENT, agent);
    code |= curl_easy_setopt(curl, CURLOPT_HTTPHEADER, c->headers);
    code |= curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE, (long)strlen(c->body));
    code |= curl_easy_setopt(curl, CURLOPT_POSTFIELDS, c->body);
    code |= curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, on_answer);
    code |= curl_easy_setopt(curl, CURLOPT_WRITEDATA, c);
    return code == CURLE_OK;
}

struct webhook_call *webhook_call_create(const struct webhook_row *row, const struct link_key *key,
                                         long answer_ms)
{
    struct webhook_call *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->row = *row;
    c->body = make_body(row);
    c->curl = curl_easy_init();
    if (!c->body || !c->curl || !add_headers(c, key) || !set_up(c, answer_ms))
        webhook_call_destroy(&c);
    return c;
}

void webhook_call_destroy(struct webhook_call **call)
{
    struct webhook_call *c = *call;
    *call = NULL;
    if (!c) return;
    if (c->curl) curl_easy_cleanup(c->curl);
    curl_slist_free_all(c->headers);
    free(c->body);
    free(c);
}

bool webhook_call_succeeded(const struct webhook_call *c, CURLcode result, char failure[256])
{
    long status = 0;
    curl_easy_getinfo(c->curl, CURLINFO_RESPONSE_CODE, &status);
    if (result == CURLE_OK && status >= 200 && status < 300) return true;
    if (result == CURLE_OK)
        snprintf(failure, 256, "it answered %ld", status);
    else
        snprintf(failure, 256, "%s", curl_easy_strerror(result));
    return false;
}
