#include "server/cli/client/client.h"

#include <curl/curl.h>
#include <errno.h>
#include <fcntl.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/job/job.h"
#include "proto/json.h"
#include "server/cli/client/client_request.h"
#include "server/cli/client/output_file.h"

#define ANSWER_LIMIT_BYTES (64u << 20)

struct answer {
    char *data;
    size_t size_bytes;
};

int client_create(const char *base_url, struct client **out)
{
    struct client *c = calloc(1, sizeof *c);
    if (!c) return ERR_MEMORY;
    c->curl = curl_easy_init();
    if (!c->curl || strlen(base_url) >= sizeof c->base_url) {
        client_destroy(&c);
        return ERR_MEMORY;
    }
    memcpy(c->base_url, base_url, strlen(base_url) + 1);
    *out = c;
    return 0;
}

void client_destroy(struct client **client)
{
    if (!*client) return;
    if ((*client)->curl) curl_easy_cleanup((*client)->curl);
    if ((*client)->token) gnutls_memset((*client)->token, 0, strlen((*client)->token));
    free((*client)->token);
    free(*client);
    *client = NULL;
}

int client_set_token(struct client *c, const char *token)
{
    c->token = strdup(token);
    return c->token ? 0 : ERR_MEMORY;
}

void client_trust(struct client *c, const char *authority)
{
    c->authority = authority;
}

void client_lend(const struct client *c, void *curl)
{
    if (c->authority) curl_easy_setopt(curl, CURLOPT_CAINFO, c->authority);
    if (!c->token) return;
    curl_easy_setopt(curl, CURLOPT_HTTPAUTH, CURLAUTH_BEARER);
    curl_easy_setopt(curl, CURLOPT_XOAUTH2_BEARER, c->token);
}

const char *client_base_url(const char *option)
{
    if (option) return option;
    const char *from_env = getenv("SHEARWATER_SERVER");
    return from_env && *from_env ? from_env : CLIENT_BASE_URL;
}

void client_stop_on(struct client *c, const volatile sig_atomic_t *stop)
{
    c->stop = stop;
}

static int check_stop(void *ctx, curl_off_t down_total, curl_off_t down, curl_off_t up_total,
                      curl_off_t up)
{
    const struct client *c = ctx;
    (void)down_total, (void)down, (void)up_total, (void)up;
    return c->stop && *c->stop;
}

/* Proxies are never asked: a render goes where it says. */
void client_begin(struct client *c, const char *path)
{
    char url[2048];
    curl_easy_reset(c->curl);
    snprintf(url, sizeof url, "%s%s", c->base_url, path);
    curl_easy_setopt(c->curl, CURLOPT_URL, url);
    curl_easy_setopt(c->curl, CURLOPT_NOPROXY, "*");
    curl_easy_setopt(c->curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(c->curl, CURLOPT_ERRORBUFFER, c->message);
    curl_easy_setopt(c->curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(c->curl, CURLOPT_CONNECTTIMEOUT, 10L);
    curl_easy_setopt(c->curl, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(c->curl, CURLOPT_XFERINFOFUNCTION, check_stop);
    curl_easy_setopt(c->curl, CURLOPT_XFERINFODATA, c);
    client_lend(c, c->curl);
    c->message[0] = '\0';
}

static size_t collect(char *data, size_t size, size_t count, void *ctx)
{
    struct answer *a = ctx;
    size_t more = size * count;
    if (a->size_bytes + more > ANSWER_LIMIT_BYTES) return 0;
    char *grown = realloc(a->data, a->size_bytes + more + 1);
    if (!grown) return 0;
    memcpy(grown + a->size_bytes, data, more);
    a->data = grown;
    a->size_bytes += more;
    a->data[a->size_bytes] = '\0';
    return more;
}

int client_code_of_status(long status)
{
    switch (status) {
    case 401:
    case 403:
        return ERR_STATE;
    case 404:
        return ERR_NOT_FOUND;
    case 409:
        return ERR_EXISTS;
    case 429:
    case 503:
        return ERR_FULL;
    default:
        return ERR_RANGE;
    }
}

/* Sets the fault to what the server said, in its own words if it spoke the problem format. */
static int refused(long status, const struct answer *a, struct fault *fault)
{
    json_t *problem = NULL;
    if (a->data) (void)json_read_foreign(a->data, a->size_bytes, &problem);
    const char *detail = json_string_value(json_object_get(problem, "detail"));
    const char *title = json_string_value(json_object_get(problem, "title"));
    const char *pointer = json_string_value(json_object_get(problem, "pointer"));
    int code =
        fault_set(fault, client_code_of_status(status), pointer ? pointer : "", "%s (HTTP %ld)",
                  detail  ? detail
                  : title ? title
                          : "the server refused",
                  status);
    json_decref(problem);
    return code;
}

static int unreachable(struct client *c, CURLcode result, struct fault *fault)
{
    const char *why = c->message[0] ? c->message : curl_easy_strerror(result);
    if (c->stop && *c->stop) return fault_set(fault, ERR_KILLED, "", "interrupted");
    if (result == CURLE_COULDNT_CONNECT || result == CURLE_COULDNT_RESOLVE_HOST)
        return fault_set(fault, ERR_IO, "",
                         "no server answers at %s: start one with `shearwater serve`, or name "
                         "another with --server",
                         c->base_url);
    return fault_set(fault, ERR_IO, "", "%s: %s", c->base_url, why);
}

int client_perform(struct client *c, long *status, struct fault *fault)
{
    CURLcode result = curl_easy_perform(c->curl);
    if (result != CURLE_OK) return unreachable(c, result, fault);
    curl_easy_getinfo(c->curl, CURLINFO_RESPONSE_CODE, status);
    return 0;
}

static int hash_file(FILE *f, const char *path, struct digest *out, struct fault *fault)
{
    static const size_t chunk_bytes = 1 << 16;
    struct digest_state *state = digest_begin();
    char *chunk = malloc(chunk_bytes);
    int error = state && chunk ? 0 : ERR_MEMORY;
    size_t got;
    while (!error && (got = fread(chunk, 1, chunk_bytes, f)) > 0)
        error = digest_update(state, chunk, got);
    if (!error && ferror(f)) error = fault_set(fault, ERR_IO, "", "%s: %s", path, strerror(errno));
    if (state) digest_finish(&state, out);
    free(chunk);
    return error;
}

static int asset_known(struct client *c, const char *url_path, bool *known, struct fault *fault)
{
    long status = 0;
    client_begin(c, url_path);
    curl_easy_setopt(c->curl, CURLOPT_NOBODY, 1L);
    int error = client_perform(c, &status, fault);
    *known = status == 200;
    return error;
}

static int upload(struct client *c, const char *url_path, FILE *f, curl_off_t size_bytes,
                  struct fault *fault)
{
    struct answer answer = {0};
    long status = 0;
    client_begin(c, url_path);
    curl_easy_setopt(c->curl, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(c->curl, CURLOPT_READDATA, f);
    curl_easy_setopt(c->curl, CURLOPT_INFILESIZE_LARGE, size_bytes);
    curl_easy_setopt(c->curl, CURLOPT_WRITEFUNCTION, collect);
    curl_easy_setopt(c->curl, CURLOPT_WRITEDATA, &answer);
    int error = client_perform(c, &status, fault);
    if (!error && status >= 400) error = refused(status, &answer, fault);
    free(answer.data);
    return error;
}

int client_put_asset(struct client *c, const char *path, struct digest *digest, struct fault *fault)
{
    char hex[DIGEST_HEX_BYTES], url_path[DIGEST_HEX_BYTES + 32];
    struct stat info;
    bool known = false;
    /* Without waiting, were it a pipe. */
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    FILE *f = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (!f || fstat(fd, &info) != 0) {
        int error = fault_set(fault, ERR_NOT_FOUND, "", "%s: %s", path, strerror(errno));
        if (f)
            fclose(f);
        else if (fd >= 0)
            close(fd);
        return error;
    }
    if (!S_ISREG(info.st_mode)) {
        fclose(f);
        return fault_set(fault, ERR_TYPE, "", "%s is not a regular file", path);
    }
    int error = hash_file(f, path, digest, fault);
    if (!error) {
        digest_to_hex(digest, hex);
        snprintf(url_path, sizeof url_path, "/v1/assets/%s", hex);
        error = asset_known(c, url_path, &known, fault);
    }
    if (!error && !known) {
        rewind(f);
        error = upload(c, url_path, f, (curl_off_t)info.st_size, fault);
    }
    fclose(f);
    return error;
}

static int parse_answer(const struct answer *a, json_t **out, struct fault *fault)
{
    if (a->size_bytes == 0) {
        *out = json_null();
        return 0;
    }
    const int error = json_read_foreign(a->data, a->size_bytes, out);
    if (!error) return 0;
    return fault_set(fault, error, "", "the server's answer %s",
                     error == ERR_MEMORY   ? "does not fit in memory"
                     : error == ERR_SYNTAX ? "is not JSON"
                                           : "has a number that is too large");
}

int client_json(struct client *c, const char *method, const char *path, const json_t *body,
                json_t **out, struct fault *fault)
{
    struct answer answer = {0};
    struct curl_slist *headers = NULL;
    char *text = json_text(body, JSON_COMPACT);
    long status = 0;
    if (body && !text) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    client_begin(c, path);
    curl_easy_setopt(c->curl, CURLOPT_CUSTOMREQUEST, method);
    if (text) {
        headers = curl_slist_append(headers, "Content-Type: application/json");
        curl_easy_setopt(c->curl, CURLOPT_HTTPHEADER, headers);
        curl_easy_setopt(c->curl, CURLOPT_POSTFIELDS, text);
    }
    curl_easy_setopt(c->curl, CURLOPT_WRITEFUNCTION, collect);
    curl_easy_setopt(c->curl, CURLOPT_WRITEDATA, &answer);
    int error = client_perform(c, &status, fault);
    if (!error && status >= 400) error = refused(status, &answer, fault);
    if (!error) error = parse_answer(&answer, out, fault);
    curl_slist_free_all(headers);
    free(answer.data);
    free(text);
    return error;
}

/* Bodies of errors are small documents: read them back from the file they went into. */
static int refused_download(FILE *f, long status, struct fault *fault)
{
    char text[4096];
    struct answer answer = {text, 0};
    rewind(f);
    answer.size_bytes = fread(text, 1, sizeof text - 1, f);
    text[answer.size_bytes] = '\0';
    return refused(status, &answer, fault);
}

/* The request begun, with what it has besides its address, into a file. */
static int download(struct client *c, const char *path, struct fault *fault)
{
    struct output_file out;
    long status = 0;
    int error = output_file_open(&out, path, fault);
    if (error) return error;
    curl_easy_setopt(c->curl, CURLOPT_WRITEDATA, out.file);
    error = client_perform(c, &status, fault);
    if (!error && status >= 400) error = refused_download(out.file, status, fault);
    int unwritten = output_file_close(&out, !error, fault);
    return error ? error : unwritten;
}

int client_download(struct client *c, const char *url_path, const char *path, struct fault *fault)
{
    client_begin(c, url_path);
    return download(c, path, fault);
}

int client_post_download(struct client *c, const char *url_path, const json_t *body,
                         const char *type, const char *path, struct fault *fault)
{
    char accept[128];
    struct curl_slist *headers = curl_slist_append(NULL, "Content-Type: application/json");
    char *text = json_text(body, JSON_COMPACT);
    if (!text) {
        curl_slist_free_all(headers);
        return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    }
    snprintf(accept, sizeof accept, "Accept: %s", type);
    headers = curl_slist_append(headers, accept);
    client_begin(c, url_path);
    curl_easy_setopt(c->curl, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(c->curl, CURLOPT_POSTFIELDS, text);
    const int error = download(c, path, fault);
    curl_slist_free_all(headers);
    free(text);
    return error;
}
