#include "server/http/request_body.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "server/http/connection_limits.h"
#include "server/http/request_check.h"

static bool check_media_type(struct request *r)
{
    const char *type = request_header(r, "Content-Type");
    size_t n = type ? strcspn(type, "; \t") : 0;
    if (n == 16 && strncasecmp(type, "application/json", 16) == 0) return true;
    request_problem(r, PROBLEM_MEDIA_TYPE, "the body must be application/json", NULL);
    return false;
}

static bool check_size(struct request *r, uint64_t size_bytes, uint64_t limit_bytes)
{
    char detail[96];
    if (size_bytes <= limit_bytes) return true;
    snprintf(detail, sizeof detail, "at most %llu bytes are taken here",
             (unsigned long long)limit_bytes);
    request_problem(r, PROBLEM_TOO_LARGE, detail, NULL);
    return false;
}

/* Extends the deadline of an upload with all that arrives. A slow one thus gives its place up soon.
 */
static void pace(struct request *r)
{
    const struct http *http = r->http;
    uint64_t ms = http->request_ms + r->file_bytes * 1000 / LIMIT_UPLOAD_PACE;
    r->connection->deadline_ms = r->file_from_ms + (ms < http->upload_ms ? ms : http->upload_ms);
}

void request_body_sleep(struct request *r)
{
    r->suspended = true;
    r->asleep_ms = uv_now(r->http->options.loop);
    connection_deadline(r->connection, 0);
    MHD_suspend_connection(r->mhd);
}

void request_body_wake(struct request *r)
{
    if (!r->suspended || r->response) return;
    r->suspended = false;
    r->file_from_ms += uv_now(r->http->options.loop) - r->asleep_ms;
    pace(r);
    MHD_resume_connection(r->mhd);
    http_kick(r->http);
}

/* Opens a file for the body before the body is asked for. request_step sees a failure. */
static bool begin_file(struct request *r)
{
    const int error = upload_begin(r, &r->upload);
    if (error == ERR_FULL)
        request_problem(r, PROBLEM_BUSY, "too many files arrive at once", NULL);
    else if (error)
        request_trouble(r, error, "no file could be made for the body");
    if (error) return false;
    r->file_from_ms = uv_now(r->http->options.loop);
    r->opens = true;
    return true;
}

void request_body_refuse(struct request *r, int error)
{
    if (error == ERR_TIMEOUT)
        request_problem(r, PROBLEM_OVERDUE,
                        "the disk takes too long to write it: nothing of the body is kept", NULL);
    else
        request_trouble(r, error, "the body could not be kept");
}

/* Refuses content codings. A packed body may unpack to any size. */
static bool check_coding(struct request *r)
{
    const char *coding = request_header(r, "Content-Encoding");
    if (!coding || strcasecmp(coding, "identity") == 0) return true;
    request_problem(r, PROBLEM_MEDIA_TYPE, "no content coding is taken: send it unpacked", NULL);
    return false;
}

/* Returns the limit of a JSON body. A change is parsed on the loop and must be short; a whole job
 * is parsed elsewhere. */
static size_t json_limit(const struct request *r)
{
    return r->match.id == ROUTE_JOB_SUBMIT ? LIMIT_JOB_BYTES : LIMIT_CHANGE_BYTES;
}

bool request_body_check(struct request *r, const struct body_claim *claim)
{
    if (claim->present && !check_coding(r)) return false;
    switch (route_of(r->match.id)->body) {
    case BODY_JSON:
        return check_media_type(r) && check_size(r, claim->size_bytes, json_limit(r));
    case BODY_FILE:
        return check_size(r, claim->size_bytes, LIMIT_ASSET_BYTES) && begin_file(r);
    case BODY_NONE:
        break;
    }
    if (!claim->present) return true;
    request_problem(r, PROBLEM_MALFORMED, "this request takes no body", NULL);
    return false;
}

/* Room grows by half: where it must be copied to grow that is a few times a body, not once a read.
 */
static bool reserve_body(struct request *r, size_t size_bytes)
{
    size_t wanted = r->body_room_bytes + r->body_room_bytes / 2;
    if (size_bytes <= r->body_room_bytes) return true;
    if (wanted > json_limit(r) + 1) wanted = json_limit(r) + 1;
    if (wanted < size_bytes) wanted = size_bytes;
    connection_limits_make_body_room(r->http, r, wanted - r->body_room_bytes);
    char *grown = realloc(r->body, wanted);
    if (!grown) return false;
    r->http->body_room_bytes += wanted - r->body_room_bytes;
    r->body = grown;
    r->body_room_bytes = wanted;
    return true;
}

/* Past its cap a body without a stated length can only be cut off. Without memory for it the rest
 * is let pass, so that the answer can be sent. */
static enum MHD_Result take_json(struct request *r, const char *data, size_t size_bytes)
{
    if (r->status) return MHD_NO; /* cut off meanwhile */
    if (r->body_bytes + size_bytes > json_limit(r)) {
        r->status = 413;
        connection_abort(r->connection, 413);
        return MHD_NO;
    }
    if (!reserve_body(r, r->body_bytes + size_bytes + 1)) {
        r->body_error = ERR_MEMORY;
        return MHD_YES;
    }
    memcpy(r->body + r->body_bytes, data, size_bytes);
    r->body_bytes += size_bytes;
    r->body[r->body_bytes] = '\0';
    return MHD_YES;
}

/* Takes a piece of the body for its file. While the disk is busy the connection sleeps, and the
 * rest comes again. After a failed write the rest of the body is ignored, so that the answer can be
 * sent. */
static enum MHD_Result take_file(struct request *r, const char *data, size_t *size_bytes)
{
    const size_t bytes = *size_bytes < UPLOAD_PIECE_BYTES ? *size_bytes : UPLOAD_PIECE_BYTES;
    if (r->file_bytes + *size_bytes > LIMIT_ASSET_BYTES) {
        r->status = 413;
        connection_abort(r->connection, 413);
        return MHD_NO;
    }
    if (!r->response && !upload_take(r->upload, data, bytes)) {
        request_body_sleep(r);
        return MHD_YES;
    }
    *size_bytes -= bytes;
    r->file_bytes += bytes;
    pace(r);
    return MHD_YES;
}

enum MHD_Result request_body_take(struct request *r, const char *data, size_t *size_bytes)
{
    if (route_of(r->match.id)->body == BODY_FILE) return take_file(r, data, size_bytes);
    const size_t bytes = *size_bytes;
    *size_bytes = 0;
    return take_json(r, data, bytes);
}
