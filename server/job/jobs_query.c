/* What people ask about jobs: rows of the store, with what is newer in memory laid over them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "server/job/jobs_table.h"

/* Longer documents are not opened for a listing. */
#define LISTED_DOCUMENT_BYTES 16384

/* RFC 3339, UTC, with milliseconds. */
static json_t *time_json(int64_t time_ms)
{
    char text[48];
    struct tm parts;
    time_t seconds = (time_t)(time_ms / 1000);
    if (!gmtime_r(&seconds, &parts)) return json_null();
    size_t n = strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
    snprintf(text + n, sizeof text - n, ".%03dZ", (int)(time_ms % 1000));
    return json_string(text);
}

static json_t *parse(const char *text)
{
    json_t *json = text ? json_loads(text, 0, NULL) : NULL;
    return json ? json : json_null();
}

/* Members of `from`, or null where it has none. */
static void copy_members(json_t *into, const json_t *from, const char *const *keys, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        json_t *value = json_object_get(from, keys[i]);
        json_object_set_new(into, keys[i], value ? json_incref(value) : json_null());
    }
}

static json_t *no_progress(void)
{
    return json_pack("{s:i,s:i,s:i,s:n,s:i,s:i}", "tiles_done", 0, "tiles_total", 0, "fraction", 0,
                     "eta_s", "frames_done", 0, "frames_total", 0);
}

/* The report of a live job, once it has been loaded, else what the store has. */
static json_t *report_of(const struct live_job *live, const struct job_row *row)
{
    if (live && live->frames) return live_job_report(live);
    json_t *report = parse(row->report);
    if (!json_is_object(report)) {
        json_decref(report);
        report = json_object();
    }
    if (live || !json_object_get(report, "progress"))
        json_object_set_new(report, "progress", no_progress());
    if (live) json_object_set_new(report, "revision", json_integer((json_int_t)live->revision));
    if (!json_object_get(report, "warnings")) json_object_set_new(report, "warnings", json_array());
    if (!json_object_get(report, "revision"))
        json_object_set_new(report, "revision", json_integer(row->updated_ms));
    return report;
}

static json_t *frames_of_rows(const char *id, const struct frame_row *rows, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++) {
        enum frame_state state = FRAME_QUEUED;
        if (rows[i].state && frame_state_from_name(rows[i].state, &state))
            json_array_append_new(list, live_job_frame_json(id, rows[i].number, state));
    }
    return list;
}

static json_t *summary_of(const struct live_job *live, const struct job_row *row)
{
    const char *state = live ? job_state_name(live->state) : row->state;
    return json_pack("{s:s,s:s,s:o,s:i}", "id", row->id, "state", state ? state : "queued",
                     "created", time_json(row->created_ms), "priority", (int)row->priority);
}

static json_t *body_of(const struct live_job *live, const struct job_row *row,
                       const struct frame_row *frames, size_t frame_count)
{
    static const char *const keys[] = {"progress", "plan",     "statistics",
                                       "warnings", "revision", "view"};
    json_t *body = summary_of(live, row);
    json_t *report = report_of(live, row);
    json_object_set_new(body, "document",
                        live && live->view ? job_write(&live->prepared->job)
                                           : parse(row->document));
    copy_members(body, report, keys, sizeof keys / sizeof keys[0]);
    json_decref(report);
    json_object_set_new(body, "error",
                        live && live->error ? json_incref(live->error) : parse(row->error));
    json_object_set_new(body, "frames",
                        live && live->frames && live->prepared
                            ? live_job_frames(live)
                            : frames_of_rows(row->id, frames, frame_count));
    return body;
}

/* Who asked what. */
struct question {
    struct jobs *jobs;
    jobs_answer answer;
    jobs_pictured pictured;
    void *ctx;
    int32_t frame;
    char id[JOB_ID_BYTES];
};

static void on_row(void *ctx, int error, const struct job_row *row, const struct frame_row *frames,
                   size_t frame_count)
{
    struct question *q = ctx;
    json_t *body = NULL;
    if (!error && !row) error = ERR_NOT_FOUND;
    if (!error) {
        body = body_of(jobs_table_find(q->jobs, row->id), row, frames, frame_count);
        error = body ? 0 : ERR_MEMORY;
    }
    q->answer(q->ctx, error, body);
    json_decref(body);
    free(q);
}

void jobs_get(struct jobs *jobs, const char *id, jobs_answer done, void *ctx)
{
    struct question *q = job_id_is_valid(id) ? calloc(1, sizeof *q) : NULL;
    if (!q) {
        done(ctx, job_id_is_valid(id) ? ERR_MEMORY : ERR_NOT_FOUND, NULL);
        return;
    }
    *q = (struct question){.jobs = jobs, .answer = done, .ctx = ctx};
    job_store_get(jobs->options.store, id, on_row, q);
}

static void add_size(json_t *line, const struct job_row *row)
{
    static const char *const keys[] = {"width", "height"};
    if (!row->document || strlen(row->document) > LISTED_DOCUMENT_BYTES) return;
    json_t *document = parse(row->document);
    copy_members(line, json_object_get(document, "image"), keys, 2);
    json_decref(document);
}

static json_t *line_of(const struct jobs *jobs, const struct job_row *row)
{
    static const char *const keys[] = {"progress", "revision"};
    const struct live_job *live = jobs_table_find(jobs, row->id);
    json_t *line = summary_of(live, row);
    json_t *report = report_of(live, row);
    copy_members(line, report, keys, 2);
    json_decref(report);
    add_size(line, row);
    return line;
}

static void on_rows(void *ctx, int error, const struct job_row *rows, size_t count, bool more)
{
    struct question *q = ctx;
    json_t *body = NULL;
    if (!error) {
        json_t *list = json_array();
        for (size_t i = 0; i < count; i++) json_array_append_new(list, line_of(q->jobs, &rows[i]));
        body = json_pack("{s:o,s:s?}", "jobs", list, "next",
                         more && count > 0 ? rows[count - 1].id : NULL);
        error = body ? 0 : ERR_MEMORY;
    }
    q->answer(q->ctx, error, body);
    json_decref(body);
    free(q);
}

void jobs_list(struct jobs *jobs, const char *state, const char *cursor, size_t limit,
               jobs_answer done, void *ctx)
{
    enum job_state known;
    if ((state && !job_state_from_name(state, &known)) || (cursor && !job_id_is_valid(cursor))) {
        done(ctx, ERR_RANGE, NULL);
        return;
    }
    struct question *q = calloc(1, sizeof *q);
    if (!q) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    *q = (struct question){.jobs = jobs, .answer = done, .ctx = ctx};
    job_store_list(jobs->options.store, state, cursor,
                   limit < LIMIT_LIST_ROWS ? limit : LIMIT_LIST_ROWS, on_rows, q);
}

/* The picture of a live job's frame. False when only the store can tell. */
static bool picture_of(const struct live_job *live, int32_t number, int *error,
                       struct jobs_picture *out)
{
    if (!live || !live->frames || !live->prepared) return false;
    int64_t at = (int64_t)number - live->prepared->job.first_frame;
    *error = at < 0 || at >= live->frame_count ? ERR_NOT_FOUND : 0;
    if (*error) return true;
    const struct live_frame *frame = &live->frames[at];
    if (live->view && frame->work && !live->view->shown) {
        out->revision = 0; /* of a view that has no picture yet */
    } else if (frame->work) {
        out->revision = frame_revision(frame->work);
        out->image = out->revision ? (struct image *)frame_image(frame->work) : NULL;
        out->metadata = frame_metadata(frame->work);
    } else if (!digest_is_zero(&frame->exr)) {
        out->finished = true;
        out->exr = frame->exr;
        out->png = frame->png;
    }
    return true;
}

static void on_picture_row(void *ctx, int error, const struct job_row *row,
                           const struct frame_row *frames, size_t frame_count)
{
    struct question *q = ctx;
    struct jobs_picture picture = {0};
    for (size_t i = 0; !error && i < frame_count; i++) {
        if (frames[i].number != q->frame || digest_is_zero(&frames[i].exr)) continue;
        picture.finished = true;
        picture.exr = frames[i].exr;
        picture.png = frames[i].png;
    }
    /* A job that waits will have the picture; one that has ended without it will not. */
    if (!error && !picture.finished && (!row || !jobs_table_find(q->jobs, q->id)))
        error = ERR_NOT_FOUND;
    q->pictured(q->ctx, error, error ? NULL : &picture);
    free(q);
}

void jobs_picture(struct jobs *jobs, const char *id, int32_t frame, jobs_pictured done, void *ctx)
{
    struct jobs_picture picture = {0};
    int error = 0;
    if (!job_id_is_valid(id)) {
        done(ctx, ERR_NOT_FOUND, NULL);
        return;
    }
    if (picture_of(jobs_table_find(jobs, id), frame, &error, &picture)) {
        done(ctx, error, error ? NULL : &picture);
        return;
    }
    struct question *q = calloc(1, sizeof *q);
    if (!q) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    *q = (struct question){.jobs = jobs, .pictured = done, .ctx = ctx, .frame = frame};
    memcpy(q->id, id, sizeof q->id);
    job_store_get(jobs->options.store, id, on_picture_row, q);
}
