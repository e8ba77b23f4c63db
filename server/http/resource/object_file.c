#include "server/http/resource/object_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/http/etag.h"
#include "server/http/range.h"

/* -1 when it is not there. */
static int open_object(const struct objects *objects, const struct digest *digest,
                       uint64_t *size_bytes)
{
    char path[OBJECTS_PATH_BYTES];
    struct stat info;
    objects_path(objects, digest, path);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd >= 0 && fstat(fd, &info) != 0) {
        close(fd);
        fd = -1;
    }
    if (fd >= 0) *size_bytes = (uint64_t)info.st_size;
    return fd;
}

/* A range counts for GET alone, and with If-Range only for the version that the client has. */
static struct range asked_range(const struct request *r, const char *etag, uint64_t size_bytes)
{
    const char *condition = request_header(r, "If-Range");
    bool applies = !request_is_head(r) && (!condition || strcmp(condition, etag) == 0);
    return range_read(applies ? request_header(r, "Range") : NULL, size_bytes);
}

static void answer_unsatisfiable(struct request *r, uint64_t size_bytes)
{
    char text[64];
    snprintf(text, sizeof text, "bytes */%llu", (unsigned long long)size_bytes);
    request_problem(r, PROBLEM_RANGE, NULL, NULL);
    response_header(r->response, "Content-Range", text);
}

static void describe(const struct request *r, struct MHD_Response *response, const char *etag,
                     const char *ending)
{
    char name[96];
    snprintf(name, sizeof name, "inline; filename=\"%s.%d.%s\"", r->match.job, (int)r->match.frame,
             ending);
    response_header(response, "ETag", etag);
    response_header(response, "Cache-Control", "no-cache");
    response_header(response, "Accept-Ranges", "bytes");
    response_header(response, "Content-Disposition", name);
}

void object_file_answer(struct request *r, const struct digest *digest, const char *type,
                        const char *ending)
{
    char etag[ETAG_BYTES], text[96];
    uint64_t size_bytes = 0;
    etag_of_digest(digest, etag);
    if (request_unchanged(r, etag)) return;
    int fd = open_object(r->http->options.objects, digest, &size_bytes);
    if (fd < 0) {
        request_problem(r, PROBLEM_NOT_FOUND, "the file is no longer stored", NULL);
        return;
    }
    struct range range = asked_range(r, etag, size_bytes);
    if (range.kind == RANGE_UNSATISFIABLE) {
        close(fd);
        answer_unsatisfiable(r, size_bytes);
        return;
    }
    struct MHD_Response *response = response_of_file(fd, range.first_byte, range.size_bytes, type);
    if (response) describe(r, response, etag, ending);
    if (response && range.kind == RANGE_PART) {
        snprintf(text, sizeof text, "bytes %llu-%llu/%llu", (unsigned long long)range.first_byte,
                 (unsigned long long)(range.first_byte + range.size_bytes - 1),
                 (unsigned long long)size_bytes);
        response_header(response, "Content-Range", text);
    }
    request_answer(r, range.kind == RANGE_PART ? 206 : 200, response);
}
