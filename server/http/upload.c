#include "server/http/upload.h"

#include <stdlib.h>
#include <string.h>

#include "server/http/request.h"
#include "server/http/request_body.h"

struct upload {
    uv_work_t work;
    struct http *http;
    struct request *request; /* NULL: it was dropped */
    /* Of the loop's thread. */
    bool busy;                     /* the pool has it */
    bool wanted;                   /* the request waits for what is under way */
    uint64_t from_ms;              /* of the loop's clock: since when it is busy */
    uint64_t wanted_ms, waited_ms; /* since when it is wanted; how long it was before */
    uint64_t written_bytes;
    size_t gathered_bytes;
    int error;
    /* Of the pool's while it is busy. */
    struct object_writer *writer; /* owned */
    size_t piece_bytes;
    bool drop; /* the file is to go */
    int result;
    uint8_t *gathering, *piece; /* of UPLOAD_PIECE_BYTES */
    uint8_t bytes[UPLOAD_PIECES][UPLOAD_PIECE_BYTES];
};

/* -- on the pool's thread -- */

static void run(uv_work_t *work)
{
    struct upload *u = work->data;
    if (u->drop)
        object_writer_abort(&u->writer);
    else if (!u->writer)
        u->result = object_writer_begin(u->http->options.objects, &u->writer);
    else
        u->result = object_writer_append(u->writer, u->piece, u->piece_bytes);
}

/* -- on the loop's thread -- */

static void free_upload(struct upload *u)
{
    struct http *http = u->http;
    http->uploads--;
    free(u);
    http_release(http);
}

static void done(uv_work_t *work, int status);

static int start(struct upload *u)
{
    u->work.data = u;
    if (uv_queue_work(u->http->options.loop, &u->work, run, done) != 0) return ERR_IO;
    u->busy = true;
    u->from_ms = uv_now(u->http->options.loop);
    return 0;
}

/* Without the pool the file is removed here. */
static void discard(struct upload *u)
{
    u->drop = true;
    if (u->writer && start(u) == 0) return;
    if (u->writer) object_writer_abort(&u->writer);
    free_upload(u);
}

static void write_gathered(struct upload *u)
{
    uint8_t *const full = u->gathering;
    u->gathering = u->piece;
    u->piece = full;
    u->piece_bytes = u->gathered_bytes;
    u->gathered_bytes = 0;
    const int error = start(u);
    if (error) u->error = error;
}

static void want(struct upload *u)
{
    u->wanted = true;
    u->wanted_ms = uv_now(u->http->options.loop);
}

static void wake(struct upload *u)
{
    if (!u->wanted) return;
    u->wanted = false;
    u->waited_ms += uv_now(u->http->options.loop) - u->wanted_ms;
    request_body_wake(u->request);
}

static void done(uv_work_t *work, int status)
{
    struct upload *u = work->data;
    u->busy = false;
    u->written_bytes += u->piece_bytes;
    if (!u->request) {
        if (u->drop)
            free_upload(u);
        else
            discard(u);
        return;
    }
    if (!u->error) u->error = status ? ERR_IO : u->result;
    if (!u->error && u->gathered_bytes > 0) write_gathered(u);
    wake(u);
}

int upload_begin(struct request *r, struct upload **out)
{
    struct http *http = r->http;
    *out = NULL;
    if (http->uploads >= UPLOADS_MAX) return ERR_FULL;
    struct upload *u = calloc(1, sizeof *u);
    if (!u) return ERR_MEMORY;
    u->http = http;
    u->request = r;
    u->gathering = u->bytes[0];
    u->piece = u->bytes[1];
    const int error = start(u);
    if (error) {
        free(u);
        return error;
    }
    http->uploads++;
    http->open_handles++;
    want(u);
    *out = u;
    return 0;
}

bool upload_take(struct upload *u, const char *data, size_t size_bytes)
{
    if (u->error) return true;
    if (u->gathered_bytes + size_bytes > UPLOAD_PIECE_BYTES) {
        want(u);
        return false;
    }
    memcpy(u->gathering + u->gathered_bytes, data, size_bytes);
    u->gathered_bytes += size_bytes;
    if (!u->busy) write_gathered(u);
    return true;
}

bool upload_is_written(struct upload *u)
{
    if (u->error || (!u->busy && u->gathered_bytes == 0)) return true;
    want(u);
    return false;
}

int upload_error(const struct upload *u)
{
    return u->error;
}

struct object_writer *upload_take_writer(struct upload *u)
{
    struct object_writer *writer = u->writer;
    u->writer = NULL;
    return writer;
}

void upload_drop(struct upload **upload)
{
    struct upload *u = *upload;
    *upload = NULL;
    if (!u) return;
    u->request = NULL;
    if (!u->busy) discard(u);
}

/* Returns whether a write takes too long. One piece has the time of an answer. All of them have
 * that time, and more with each byte written, at the pace that clients must keep, too. */
static bool is_overdue(const struct upload *u)
{
    const struct http *http = u->http;
    const uint64_t now_ms = uv_now(http->options.loop);
    const uint64_t paced_ms = http->pending.answer_ms + u->written_bytes * 1000 / LIMIT_UPLOAD_PACE;
    const uint64_t most_ms = paced_ms < http->upload_ms ? paced_ms : http->upload_ms;
    return u->wanted && u->busy &&
           (now_ms - u->from_ms >= http->pending.answer_ms ||
            u->waited_ms + now_ms - u->wanted_ms >= most_ms);
}

void upload_tick(struct http *http)
{
    for (struct request *r = http->requests; r; r = r->next) {
        struct upload *u = r->upload;
        if (!u || !is_overdue(u)) continue;
        u->error = ERR_TIMEOUT;
        http->pending.overdue++;
        wake(u);
    }
}
