#include "server/http/response.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/json.h"

/* Headers of all answers. Pages may load their own files and nothing else, and no page may frame or
 * embed an answer. */
static const struct {
    const char *name, *value;
} protection[] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
     "connect-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Embedder-Policy", "require-corp"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
};

bool response_protect(struct MHD_Response *response, const char *type)
{
    bool ok = true;
    for (size_t i = 0; i < sizeof protection / sizeof protection[0]; i++)
        ok &= MHD_add_response_header(response, protection[i].name, protection[i].value) == MHD_YES;
    if (type) ok &= MHD_add_response_header(response, "Content-Type", type) == MHD_YES;
    return ok;
}

void response_header(struct MHD_Response *response, const char *name, const char *value)
{
    (void)MHD_add_response_header(response, name, value);
}

static struct MHD_Response *protected_or_null(struct MHD_Response *response, const char *type)
{
    if (response && !response_protect(response, type)) {
        MHD_destroy_response(response);
        return NULL;
    }
    return response;
}

/* MHD takes a pointer to non-const and only reads through it. */
static struct MHD_Response *of_buffer(const void *data, size_t size_bytes, const char *type,
                                      enum MHD_ResponseMemoryMode mode)
{
    return protected_or_null(
        MHD_create_response_from_buffer(size_bytes, (void *)(uintptr_t)data, mode), type);
}

struct MHD_Response *response_of_copy(const void *data, size_t size_bytes, const char *type)
{
    return of_buffer(data, size_bytes, type, MHD_RESPMEM_MUST_COPY);
}

struct MHD_Response *response_of_borrowed(const void *data, size_t size_bytes, const char *type)
{
    return of_buffer(data, size_bytes, type, MHD_RESPMEM_PERSISTENT);
}

struct MHD_Response *response_of_taken(void *data, size_t size_bytes, const char *type)
{
    struct MHD_Response *response =
        MHD_create_response_from_buffer(size_bytes, data, MHD_RESPMEM_MUST_FREE);
    if (!response) free(data);
    return protected_or_null(response, type);
}

struct MHD_Response *response_of_json(const json_t *body, const char *type)
{
    char *text = json_text(body, JSON_COMPACT);
    return text ? response_of_taken(text, strlen(text), type) : NULL;
}

struct MHD_Response *response_of_file(int fd, uint64_t first_byte, uint64_t size_bytes,
                                      const char *type)
{
    struct MHD_Response *response =
        MHD_create_response_from_fd_at_offset64(size_bytes, fd, first_byte);
    if (!response) close(fd);
    return protected_or_null(response, type);
}

struct MHD_Response *response_without_memory(unsigned *status)
{
    static const char body[] = "{\"type\":\"urn:shearwater:problem:out-of-memory\","
                               "\"title\":\"The server is out of memory\",\"status\":503}";
    *status = 503;
    struct MHD_Response *response =
        response_of_borrowed(body, sizeof body - 1, "application/problem+json");
    if (response) response_header(response, "Retry-After", "5");
    return response ? response : response_empty();
}

struct MHD_Response *response_empty(void)
{
    return response_of_borrowed("", 0, NULL);
}

static ssize_t no_body(void *ctx, uint64_t position, char *out, size_t max_bytes)
{
    (void)ctx;
    (void)position;
    (void)out;
    (void)max_bytes;
    return MHD_CONTENT_READER_END_WITH_ERROR;
}

struct MHD_Response *response_of_length(uint64_t size_bytes)
{
    return protected_or_null(MHD_create_response_from_callback(size_bytes, 1, no_body, NULL, NULL),
                             NULL);
}
