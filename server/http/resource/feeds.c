/* /v1/jobs/{id}/events and /v1/jobs/{id}/pixels: what goes out while a job runs. */
#include <stdlib.h>
#include <string.h>

#include "proto/job/job.h"
#include "server/http/request.h"
#include "server/http/resource/picture.h"
#include "server/job/frame/state.h"

static bool has_ended(const json_t *body)
{
    const char *name = json_string_value(json_object_get(body, "state"));
    enum job_state state;
    return name && job_state_from_name(name, &state) && job_state_is_final(state);
}

static void answer_feed(struct request *r, struct MHD_Response *response, const char *type)
{
    if (response && response_protect(response, type)) {
        response_header(response, "Cache-Control", "no-store");
        response_header(response, "X-Accel-Buffering", "no");
    }
    r->streams = true;
    request_answer(r, 200, response);
}

/* The head alone of an answer without a length. MHD would put the end of a chunked body behind it,
 * which the next answer on the connection would be read from: so it is said to end with that. */
static void answer_head(struct request *r, const char *type)
{
    struct MHD_Response *response = response_of_length(MHD_SIZE_UNKNOWN);
    if (response) {
        MHD_set_response_options(response, MHD_RF_HTTP_1_0_COMPATIBLE_STRICT, MHD_RO_END);
        response_header(response, "Content-Type", type);
        response_header(response, "Cache-Control", "no-store");
    }
    request_answer(r, 200, response);
}

/* False when the lookup of the job failed, which the client is told. */
static bool found(struct request *r, int error, const json_t *body)
{
    if (!error && body) return true;
    if (!error || error == ERR_NOT_FOUND)
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such job", NULL);
    else
        request_trouble(r, error, error_text(error));
    return false;
}

static void on_events(void *ctx, int error, json_t *body)
{
    struct request *r = ctx;
    if (!request_back(r) || !found(r, error, body)) return;
    if (request_is_head(r)) {
        answer_head(r, "text/event-stream");
        return;
    }
    struct streams *streams = r->http->options.streams;
    const char *last = request_header(r, "Last-Event-ID");
    answer_feed(r,
                stream_events_response(streams, r->match.job, r->mhd,
                                       last ? streams_event_id(streams, last) : 0,
                                       json_incref(body), has_ended(body)),
                "text/event-stream");
}

void route_events(struct request *r)
{
    request_hold(r);
    jobs_get(r->http->options.jobs, &r->principal, r->match.job, on_events, r);
}

static bool has_layer(const json_t *body, const char *layer)
{
    const json_t *layers = json_object_get(json_object_get(body, "document"), "layers");
    size_t i;
    json_t *name;
    json_array_foreach (layers, i, name)
        if (json_is_string(name) && strcmp(json_string_value(name), layer) == 0) return true;
    return false;
}

static int32_t first_frame(const json_t *body)
{
    struct job job;
    const int error = job_frames_of(json_object_get(body, "document"), &job);
    return error ? 0 : job_frame_number(&job, 0);
}

/* Reads the number of the frame that is asked for into r->match, -1 where none is. Returns false,
 * and sends a problem, when it is no number. */
static bool read_frame(struct request *r)
{
    const char *text = target_parameter(&r->target, "frame");
    const size_t digits = text ? strspn(text, "0123456789") : 1;
    const long number = text && digits <= 10 ? strtol(text, NULL, 10) : -1;
    const bool fits =
        digits >= 1 && digits <= 10 && (!text || !text[digits]) && number <= INT32_MAX;
    if (fits)
        r->match.frame = (int32_t)number;
    else
        request_problem(r, PROBLEM_MALFORMED, "frame must be the number of a frame", NULL);
    return fits;
}

static void on_pixels(void *ctx, int error, json_t *body)
{
    struct request *r = ctx;
    struct pixels_request wanted;
    if (!request_back(r) || !found(r, error, body) || !picture_pixels_request(r, &wanted)) return;
    if (!has_layer(body, wanted.layer)) {
        request_problem(r, PROBLEM_NOT_FOUND, "the job does not have this layer", NULL);
    } else if (request_is_head(r)) {
        answer_head(r, "application/octet-stream");
    } else if (r->match.frame >= 0) {
        picture_feed(r);
    } else if (has_ended(body)) {
        r->match.frame = first_frame(body);
        picture_feed(r);
    } else {
        answer_feed(r,
                    stream_pixels_response(r->http->options.streams, r->match.job, r->mhd, &wanted),
                    "application/octet-stream");
    }
}

void route_pixels(struct request *r)
{
    struct pixels_request wanted;
    if (!picture_pixels_request(r, &wanted) || !read_frame(r)) return;
    request_hold(r);
    jobs_get(r->http->options.jobs, &r->principal, r->match.job, on_pixels, r);
}
