/* /v1/jobs/{id}/frames/{n}/image.exr and image.png. */
#include "server/http/resource/picture.h"

#include <stdlib.h>
#include <string.h>

#include "server/http/etag.h"
#include "server/http/resource/object_file.h"
#include "server/http/resource/picture_task.h"
#include "server/http/resource/png_query.h"

#define ENCODINGS_MAX 2u /* at once: each holds copies of planes */

const char *picture_layer(const struct request *r)
{
    const char *layer = target_parameter(&r->target, "layer");
    return layer ? layer : "beauty";
}

bool picture_layer_is_known(struct request *r)
{
    if (layer_from_name(picture_layer(r)) != 0) return true;
    request_problem(r, PROBLEM_MALFORMED, "layer must be the name of a layer, such as beauty",
                    NULL);
    return false;
}

static bool read_format(const char *text, enum pixels_format *out)
{
    *out = text && strcmp(text, "float") == 0 ? PIXELS_F32 : PIXELS_F16;
    return !text || *out == PIXELS_F32 || strcmp(text, "half") == 0;
}

/* Asks for alpha beside the colours. */
static bool read_alpha(const char *text, enum pixels_format *format)
{
    if (text && strcmp(text, "1") == 0)
        *format = *format == PIXELS_F16 ? PIXELS_F16_ALPHA : PIXELS_F32_ALPHA;
    return !text || strcmp(text, "1") == 0 || strcmp(text, "0") == 0;
}

static bool read_revision(const char *text, uint64_t *out)
{
    size_t digits = text ? strspn(text, "0123456789") : 1;
    *out = text && digits <= 19 ? strtoull(text, NULL, 10) : 0;
    return digits >= 1 && digits <= 19 && (!text || !text[digits]);
}

bool picture_pixels_request(struct request *r, struct pixels_request *out)
{
    *out = (struct pixels_request){.layer = picture_layer(r)};
    if (!picture_layer_is_known(r)) return false;
    const char *fault = NULL;
    if (!read_format(target_parameter(&r->target, "format"), &out->format))
        fault = "format must be half or float";
    else if (!read_alpha(target_parameter(&r->target, "alpha"), &out->format))
        fault = "alpha must be 0 or 1";
    else if (!read_revision(target_parameter(&r->target, "after"), &out->after))
        fault = "after must be a revision that the feed gave";
    if (fault) request_problem(r, PROBLEM_MALFORMED, fault, NULL);
    return !fault;
}

/* Counts an encoding that begins; false, and a problem is sent, when too many are in work. */
static bool may_encode(struct request *r)
{
    if (r->http->encodings >= ENCODINGS_MAX) {
        request_problem(r, PROBLEM_BUSY, "other pictures are being encoded", NULL);
        return false;
    }
    return true;
}

static void start(struct request *r, struct picture_task *t)
{
    if (!t) {
        request_trouble(r, ERR_MEMORY, NULL);
        return;
    }
    r->http->encodings++;
    r->encodes = true;
    picture_task_start(t, r);
}

/* Starts the work unless the client has this very picture. */
static void start_unless_known(struct request *r, struct picture_task *t)
{
    if (t && request_unchanged(r, t->etag))
        picture_task_destroy(&t);
    else
        start(r, t);
}

static const char *stored_layer(const struct jobs_picture *picture)
{
    return picture->shows_composite ? "composite" : "beauty";
}

/* Returns the layer that is asked for, else that of the PNG. */
static const char *shown_layer(const struct request *r, const struct jobs_picture *picture)
{
    const char *layer = target_parameter(&r->target, "layer");
    return layer ? layer : stored_layer(picture);
}

/* Reads how a layer is asked for. False: a problem is sent. */
static bool read_png_options(struct request *r, const struct jobs_picture *picture,
                             struct png_options *out)
{
    const struct png_options own =
        png_options_of_layer(&picture->png_options, shown_layer(r, picture));
    return png_query_read(r, &own, out);
}

/* Begins a tag of what a PNG file is of, and adds what it is like. */
static void tag(struct picture_task *t, const char *of)
{
    const struct png_options *o = &t->png_options;
    snprintf(t->etag, sizeof t->etag, "\"%.40s-%.24s-%g-%d%d%d\"", of, t->layer,
             (double)o->exposure_ev, (int)o->view, o->is_deep, o->alpha);
}

static void answer_so_far(struct request *r, const struct jobs_picture *picture)
{
    char of[48];
    struct png_options options;
    const struct picture_source source = {.image = picture->image,
                                          .metadata = picture->metadata,
                                          .layer = shown_layer(r, picture),
                                          .objects = r->http->options.objects};
    if (!picture->image) {
        request_problem(r, PROBLEM_NOT_FOUND, "no tile of this frame is there yet", NULL);
        return;
    }
    if (!read_png_options(r, picture, &options) || !may_encode(r)) return;
    struct picture_task *t =
        picture_task_create(r->match.id == ROUTE_IMAGE_EXR ? PICTURE_EXR : PICTURE_PNG, &source);
    if (t) {
        t->png_options = options;
        t->so_far = true;
        snprintf(of, sizeof of, "%llx-%llx", (unsigned long long)r->http->start_ns,
                 (unsigned long long)picture->revision);
        tag(t, of);
    }
    start_unless_known(r, t);
}

/* Another layer or look than the stored PNG's is made from the EXR. */
static void answer_from_exr(struct request *r, const struct jobs_picture *picture,
                            const struct png_options *options)
{
    char hex[DIGEST_HEX_BYTES];
    const struct picture_source source = {.exr = &picture->exr,
                                          .layer = shown_layer(r, picture),
                                          .objects = r->http->options.objects};
    struct picture_task *t = may_encode(r) ? picture_task_create(PICTURE_PNG, &source) : NULL;
    if (r->response) return;
    if (t) {
        t->png_options = *options;
        digest_to_hex(&picture->exr, hex);
        hex[24] = '\0';
        tag(t, hex);
    }
    start_unless_known(r, t);
}

static void answer_finished(struct request *r, const struct jobs_picture *picture)
{
    struct png_options options;
    if (r->match.id == ROUTE_IMAGE_EXR) {
        object_file_answer(r, &picture->exr, "image/x-exr", "exr");
        return;
    }
    if (!read_png_options(r, picture, &options)) return;
    bool as_stored = png_query_is_same(&options, &picture->png_options) &&
                     strcmp(shown_layer(r, picture), stored_layer(picture)) == 0;
    if (as_stored && !digest_is_zero(&picture->png))
        object_file_answer(r, &picture->png, "image/png", "png");
    else
        answer_from_exr(r, picture, &options);
}

static bool found(struct request *r, int error, const struct jobs_picture *picture)
{
    if (!error && picture) return true;
    if (!error || error == ERR_NOT_FOUND)
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such job or frame, or no picture yet",
                        NULL);
    else if (error == ERR_STATE)
        request_problem(r, PROBLEM_NOT_FOUND, "the frame has no picture yet", NULL);
    else
        request_trouble(r, error, error_text(error));
    return false;
}

static void on_picture(void *ctx, int error, const struct jobs_picture *picture)
{
    struct request *r = ctx;
    if (!request_back(r) || !found(r, error, picture)) return;
    if (picture->finished)
        answer_finished(r, picture);
    else
        answer_so_far(r, picture);
}

static void ask(struct request *r, jobs_pictured done)
{
    request_hold(r);
    jobs_picture(r->http->options.jobs, &r->principal, r->match.job, r->match.frame, done, r);
}

void route_image_exr(struct request *r)
{
    ask(r, on_picture);
}

void route_image_png(struct request *r)
{
    const struct png_options any = {0};
    struct png_options options;
    if (picture_layer_is_known(r) && png_query_read(r, &any, &options)) ask(r, on_picture);
}

static void on_feed(void *ctx, int error, const struct jobs_picture *picture)
{
    struct request *r = ctx;
    if (!request_back(r)) return;
    if (error == ERR_NOT_FOUND || (!error && picture && !picture->finished)) {
        const bool is_asked_for = target_parameter(&r->target, "frame") != NULL;
        request_problem(r, PROBLEM_ENDED,
                        is_asked_for ? "it has no such frame that is finished"
                                     : "it ended without a picture",
                        NULL);
        return;
    }
    if (!found(r, error, picture)) return;
    const struct picture_source source = {
        .exr = &picture->exr, .layer = picture_layer(r), .objects = r->http->options.objects};
    if (may_encode(r)) start(r, picture_task_create(PICTURE_FEED, &source));
}

void picture_feed(struct request *r)
{
    ask(r, on_feed);
}
