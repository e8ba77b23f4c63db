/* What people ask about jobs: rows of the store, with what is newer in memory laid over them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/frame/picture_file.h"
#include "server/job/job_log.h"
#include "server/job/jobs_table.h"

/* Longer documents are not opened for a listing. */
#define LISTED_DOCUMENT_BYTES 16384

/* Without memory a part is missing: json_text says so. */
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
    return json_pack("{s:i,s:i,s:i,s:n,s:n,s:i,s:i}", "tiles_done", 0, "tiles_total", 0, "fraction",
                     0, "eta_s", "eta_range_s", "frames_done", 0, "frames_total", 0);
}

/* Returns the report of an active job, once it has been loaded, else what the store has. */
static json_t *report_of(const struct active_job *active, const struct job_row *row)
{
    if (active && active->frames) return active_job_report(active);
    json_t *report = parse(row->report);
    if (!json_is_object(report)) {
        json_decref(report);
        report = json_object();
    }
    if (active || !json_object_get(report, "progress"))
        json_object_set_new(report, "progress", no_progress());
    if (active) json_object_set_new(report, "revision", json_integer((json_int_t)active->revision));
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
            json_array_append_new(list, active_job_frame_json(id, rows[i].number, state));
    }
    return list;
}

/* Returns whether a job that is not in the table is paused. */
static bool is_paused(const struct job_row *row)
{
    enum job_state state;
    return row->paused && row->state && job_state_from_name(row->state, &state) &&
           !job_state_is_final(state);
}

/* Makes an array of a row's labels: "\na\nb\n". */
static json_t *labels_of(const struct job_row *row)
{
    json_t *array = json_array();
    const char *at = row->labels && *row->labels ? row->labels + 1 : "";
    for (const char *end; (end = strchr(at, '\n')); at = end + 1)
        json_array_append_new(array, json_stringn(at, (size_t)(end - at)));
    return array;
}

static json_t *summary_of(const struct active_job *active, const struct job_row *row)
{
    const char *state = active ? job_state_name(active->state) : row->state;
    return json_pack("{s:s,s:s,s:s?,s:o,s:s,s:o,s:o,s:i,s:b}", "id", row->id, "state",
                     state ? state : "queued", "name", row->name, "labels", labels_of(row), "owner",
                     row->owner, "thumbnail", jobs_thumbnail_address(active, row), "created",
                     time_json(row->created_ms), "priority",
                     (int)(active ? active->priority : row->priority), "paused",
                     (int)(active ? active_job_is_paused(active) : is_paused(row)));
}

/* Adds the tile priority to the body. */
static void add_tile_priority(json_t *body, const struct active_job *active)
{
    const struct tile_priority none = {0}, *priority = active ? &active->tile_priority : &none;
    const struct rect r = priority->region;
    json_object_set_new(body, "region",
                        rect_is_empty(r)
                            ? json_null()
                            : json_pack("{s:i,s:i,s:i,s:i}", "x", r.x0, "y", r.y0, "width",
                                        rect_width(r), "height", rect_height(r)));
    json_object_set_new(body, "near",
                        priority->has_near
                            ? json_pack("{s:i,s:i}", "x", priority->near_x, "y", priority->near_y)
                            : json_null());
}

/* Adds the frames of a job that is not loaded. Those that are finished stay so. */
static void add_stored_frames(json_t *body, const struct frame_row *frames, size_t count)
{
    json_t *progress = json_object_get(body, "progress");
    struct job job;
    const bool known = job_frames_of(json_object_get(body, "document"), &job) == 0;
    const json_int_t total = known ? job_frame_count(&job) : 0;
    json_int_t done = 0;
    for (size_t i = 0; i < count; i++) {
        enum frame_state state;
        done += frames[i].state && frame_state_from_name(frames[i].state, &state) &&
                state == FRAME_FINISHED;
    }
    if (!json_is_object(progress) || total < 1 || done > total) return;
    json_object_set_new(progress, "frames_done", json_integer(done));
    json_object_set_new(progress, "frames_total", json_integer(total));
    json_object_set_new(progress, "fraction", json_real((double)done / (double)total));
}

/* Makes the log of a job that is not loaded. One that waits has a single line. */
static json_t *log_of(const json_t *report, const struct job_row *row)
{
    json_t *log = job_log_read(report);
    if (!log) job_log_add(&log, row->created_ms, "state", LOG_SUBMITTED);
    return log ? log : json_array();
}

/* Returns the document; of a live job with the camera and lens that it now has. */
static json_t *document_of(const struct active_job *active, const struct job_row *row)
{
    static const char *const marks[] = {"name", "comment", "labels"};
    json_t *stored = parse(row->document);
    if (!active || !active->view) return stored;
    json_t *document = job_write(&active->prepared->job);
    copy_members(document, stored, marks, sizeof marks / sizeof marks[0]);
    json_decref(stored);
    return document;
}

static json_t *body_of(const struct active_job *active, const struct job_row *row,
                       const struct frame_row *frames, size_t frame_count)
{
    static const char *const keys[] = {"progress", "plan",     "statistics",
                                       "warnings", "revision", "view"};
    json_t *body = summary_of(active, row);
    json_t *report = report_of(active, row);
    json_object_set_new(body, "log", log_of(report, row));
    add_tile_priority(body, active);
    json_object_set_new(body, "document", document_of(active, row));
    copy_members(body, report, keys, sizeof keys / sizeof keys[0]);
    json_decref(report);
    if (active && !active->frames) add_stored_frames(body, frames, frame_count);
    json_object_set_new(body, "error",
                        active && active->error ? json_incref(active->error) : parse(row->error));
    json_object_set_new(body, "frames",
                        active && active->frames && active->prepared
                            ? active_job_frames(active)
                            : frames_of_rows(row->id, frames, frame_count));
    return body;
}

/* A query, and the principal that asks it. */
struct question {
    struct jobs *jobs;
    jobs_answer answer;
    jobs_pictured pictured;
    void *ctx;
    struct principal principal;
    int32_t frame;
    char id[JOB_ID_BYTES];
};

static void on_row(void *ctx, int error, const struct job_row *row, const struct frame_row *frames,
                   size_t frame_count)
{
    struct question *q = ctx;
    json_t *body = NULL;
    if (!error && (!row || !principal_sees(&q->principal, row->owner))) error = ERR_NOT_FOUND;
    if (!error) {
        body = body_of(jobs_table_find(q->jobs, row->id), row, frames, frame_count);
        error = body ? 0 : ERR_MEMORY;
    }
    q->answer(q->ctx, error, body);
    json_decref(body);
    free(q);
}

void jobs_get(struct jobs *jobs, const struct principal *principal, const char *id,
              jobs_answer done, void *ctx)
{
    struct question *q = job_id_is_valid(id) ? calloc(1, sizeof *q) : NULL;
    if (!q) {
        done(ctx, job_id_is_valid(id) ? ERR_MEMORY : ERR_NOT_FOUND, NULL);
        return;
    }
    *q = (struct question){.jobs = jobs, .answer = done, .ctx = ctx, .principal = *principal};
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
    const struct active_job *active = jobs_table_find(jobs, row->id);
    json_t *line = summary_of(active, row);
    json_t *report = report_of(active, row);
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

void jobs_list(struct jobs *jobs, const struct principal *principal,
               const struct job_listing *listing, jobs_answer done, void *ctx)
{
    struct job_listing seen = *listing;
    if (!principal->sees_all) seen.owner = principal->owner;
    enum job_state known;
    if ((listing->state && !job_state_from_name(listing->state, &known)) ||
        (listing->cursor && !job_id_is_valid(listing->cursor))) {
        done(ctx, ERR_RANGE, NULL);
        return;
    }
    struct question *q = calloc(1, sizeof *q);
    if (!q) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    *q = (struct question){.jobs = jobs, .answer = done, .ctx = ctx};
    job_store_list(jobs->options.store, &seen, on_rows, q);
}

/* Returns the frame whose image is shown. Between two levels of a view it is the coarser one. NULL:
 * there is none. */
static const struct frame *shown_of(const struct active_job *active,
                                    const struct active_frame *frame)
{
    return active->view && !active->view->shown ? active->view->last : frame->work;
}

/* Frames of a view, and of the views before, have the same blocks. */
bool jobs_picture_so_far(const struct active_job *active, const struct active_frame *frame,
                         struct jobs_picture *out)
{
    const struct frame *work = shown_of(active, frame);
    const uint64_t drawn = work ? frame_revision(work) : 0;
    if (drawn == 0) return false;
    out->revision = frame_id(work) << 32 | drawn;
    out->image = (struct image *)frame_image(work);
    out->metadata = frame_metadata(work);
    return true;
}

/* Finds the picture of an active job's frame. False when only the store can tell. */
static bool picture_of(const struct active_job *active, int32_t number, int *error,
                       struct jobs_picture *out)
{
    if (!active || !active->frames || !active->prepared) return false;
    uint32_t at;
    *error = job_frame_find(&active->prepared->job, number, &at) ? 0 : ERR_NOT_FOUND;
    if (*error) return true;
    const struct active_frame *frame = &active->frames[at];
    out->png_options = picture_png_options(&active->prepared->job);
    out->shows_composite = active->prepared->job.layers & LAYER_COMPOSITE;
    if (frame->work && !frame->recalled) {
        jobs_picture_so_far(active, frame, out);
    } else if (!digest_is_zero(&frame->exr)) {
        out->finished = true;
        out->exr = frame->exr;
        out->png = frame->png;
    }
    return true;
}

/* A document that cannot be read has the defaults. */
static void find_look(const struct job_row *row, struct jobs_picture *out)
{
    struct job job;
    struct fault fault;
    if (!row->document || job_read(row->document, strlen(row->document), &job, &fault) != 0) return;
    out->png_options = picture_png_options(&job);
    out->shows_composite = job.layers & LAYER_COMPOSITE;
    job_fini(&job);
}

static void on_picture_row(void *ctx, int error, const struct job_row *row,
                           const struct frame_row *frames, size_t frame_count)
{
    struct question *q = ctx;
    struct jobs_picture picture = {0};
    if (!error && (!row || !principal_sees(&q->principal, row->owner))) error = ERR_NOT_FOUND;
    for (size_t i = 0; !error && i < frame_count; i++) {
        if (frames[i].number != q->frame || digest_is_zero(&frames[i].exr)) continue;
        picture.finished = true;
        picture.exr = frames[i].exr;
        picture.png = frames[i].png;
        find_look(row, &picture);
    }
    /* A job that waits will have the picture; one that has ended without it will not. */
    if (!error && !picture.finished && !jobs_table_find(q->jobs, q->id)) error = ERR_NOT_FOUND;
    q->pictured(q->ctx, error, error ? NULL : &picture);
    free(q);
}

void jobs_picture(struct jobs *jobs, const struct principal *principal, const char *id,
                  int32_t frame, jobs_pictured done, void *ctx)
{
    const struct active_job *active = jobs_table_find(jobs, id);
    struct jobs_picture picture = {0};
    int error = 0;
    if (!job_id_is_valid(id) || (active && !principal_sees(principal, active->owner))) {
        done(ctx, ERR_NOT_FOUND, NULL);
        return;
    }
    if (picture_of(active, frame, &error, &picture)) {
        done(ctx, error, error ? NULL : &picture);
        return;
    }
    struct question *q = calloc(1, sizeof *q);
    if (!q) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    *q = (struct question){
        .jobs = jobs, .pictured = done, .ctx = ctx, .principal = *principal, .frame = frame};
    memcpy(q->id, id, sizeof q->id);
    job_store_get(jobs->options.store, id, on_picture_row, q);
}
