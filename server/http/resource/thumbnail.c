/* /v1/jobs/{id}/thumbnail: a small PNG of a job's latest picture. It is made once of a job that has
 * ended, and kept with it. */
#include <stdlib.h>

#include "server/http/etag.h"
#include "server/http/request.h"
#include "server/image/png.h"
#include "server/image/thumbnail.h"
#include "server/job/jobs.h"

struct thumbnail_task {
    struct pool_task task;
    struct request *request;
    struct image *image;        /* owned: small; NULL: read from png_path */
    struct png_options options; /* of the image */
    char png_path[OBJECTS_PATH_BYTES];
    char id[JOB_ID_BYTES];
    char etag[ETAG_BYTES];
    bool ended;
    /* What came of it. */
    int error;
    uint8_t *png; /* owned */
    size_t png_bytes;
};

static void destroy(struct thumbnail_task *t)
{
    image_destroy(&t->image);
    free(t->png);
    free(t);
}

/* Browsers ask again each time, and mostly hear that nothing has changed. */
static void answer(struct request *r, struct MHD_Response *response, const char *etag)
{
    if (response) {
        response_header(response, "ETag", etag);
        response_header(response, "Cache-Control", "private, no-cache");
    }
    request_answer(r, 200, response);
}

static void run(struct pool_task *task)
{
    struct thumbnail_task *t = (struct thumbnail_task *)task;
    t->error = t->image ? png_encode(t->image, "beauty", &t->options, &t->png, &t->png_bytes)
                        : thumbnail_of_png(t->png_path, &t->png, &t->png_bytes);
}

static void finish(struct request *r, struct thumbnail_task *t)
{
    if (t->error) {
        request_trouble(r, t->error, "the thumbnail could not be made");
        return;
    }
    if (t->ended) job_store_keep_thumbnail(r->http->options.store, t->id, t->png, t->png_bytes);
    if (request_unchanged(r, t->etag)) return;
    answer(r, response_of_taken(t->png, t->png_bytes, "image/png"), t->etag);
    t->png = NULL;
}

static void done(struct pool_task *task)
{
    struct thumbnail_task *t = (struct thumbnail_task *)task;
    if (request_back(t->request)) finish(t->request, t);
    destroy(t);
}

/* Makes a small copy of the image that forms, or finds the finished file. The tag is that of what
 * the thumbnail is made of, so that it is the same whether or not it is kept. */
static int prepare(struct request *r, const struct jobs_thumbnail *source, struct thumbnail_task *t)
{
    char hex[DIGEST_HEX_BYTES];
    t->ended = source->ended;
    snprintf(t->id, sizeof t->id, "%s", r->match.job);
    if (source->image) {
        t->options = source->png_options;
        snprintf(t->etag, sizeof t->etag, "\"%llx-%llx-small\"",
                 (unsigned long long)r->http->start_ns, (unsigned long long)source->revision);
        return thumbnail_of_image(source->image, &t->image);
    }
    digest_to_hex(&source->png, hex);
    snprintf(t->etag, sizeof t->etag, "\"%s-small\"", hex);
    objects_path(r->http->options.objects, &source->png, t->png_path);
    return 0;
}

static void make(struct request *r, const struct jobs_thumbnail *source)
{
    struct thumbnail_task *t = calloc(1, sizeof *t);
    const int error = t ? prepare(r, source, t) : ERR_MEMORY;
    if (error == ERR_NOT_FOUND)
        request_problem(r, PROBLEM_NOT_FOUND, "the job has no layer beauty to show", NULL);
    else if (error)
        request_trouble(r, error, NULL);
    if (error || request_unchanged(r, t->etag)) {
        if (t) destroy(t);
        return;
    }
    t->task = (struct pool_task){.run = run, .done = done};
    t->request = r;
    request_hold(r);
    thread_pool_submit(r->http->options.pool, &t->task);
}

static void on_found(void *ctx, int error, const struct jobs_thumbnail *source)
{
    struct request *r = ctx;
    char hex[DIGEST_HEX_BYTES], etag[ETAG_BYTES];
    if (!request_back(r)) return;
    if (error == ERR_NOT_FOUND) {
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such job", NULL);
    } else if (error == ERR_MISSING) { /* also of one that was cancelled since a list told of it */
        request_answer(r, 204, response_empty());
    } else if (error) {
        request_trouble(r, error, error_text(error));
    } else if (!source->kept) {
        make(r, source);
    } else {
        digest_to_hex(&source->png, hex);
        snprintf(etag, sizeof etag, "\"%s-small\"", hex);
        if (!request_unchanged(r, etag))
            answer(r, response_of_copy(source->kept, source->kept_bytes, "image/png"), etag);
    }
}

void route_thumbnail(struct request *r)
{
    request_hold(r);
    jobs_thumbnail(r->http->options.jobs, &r->principal, r->match.job, on_found, r);
}
