#include "server/store/job_record.h"

#include <stdlib.h>
#include <string.h>

bool job_record_digest(sqlite3_stmt *s, int column, struct digest *out)
{
    *out = (struct digest){0};
    const void *bytes = sqlite3_column_blob(s, column);
    if (!bytes || sqlite3_column_bytes(s, column) != DIGEST_BYTES) return false;
    memcpy(out->bytes, bytes, DIGEST_BYTES);
    return true;
}

static void short_text(sqlite3_stmt *s, int column, char *out, size_t capacity)
{
    const unsigned char *text = sqlite3_column_text(s, column);
    out[0] = 0;
    if (text) strncat(out, (const char *)text, capacity - 1);
}

void job_record_id(sqlite3_stmt *s, int column, char out[JOB_ID_BYTES])
{
    short_text(s, column, out, JOB_ID_BYTES);
}

static const char *const frame_states[] = {"queued", "rendering", "encoding", "finished"};

/* The static text of a frame's state; an unknown one (there is none) reads as the first. */
static const char *frame_state(const unsigned char *text)
{
    size_t count = sizeof frame_states / sizeof frame_states[0];
    for (size_t i = 0; text && i < count; i++) {
        if (!strcmp((const char *)text, frame_states[i])) return frame_states[i];
    }
    return frame_states[0];
}

int job_record_add_frame(struct job_record *job, sqlite3_stmt *s)
{
    if (job->frame_count == job->frame_capacity) {
        size_t grown = job->frame_capacity ? job->frame_capacity * 2 : 8;
        struct frame_row *frames = realloc(job->frames, grown * sizeof *frames);
        if (!frames) return ERR_MEMORY;
        job->frames = frames;
        job->frame_capacity = grown;
    }
    struct frame_row *frame = &job->frames[job->frame_count++];
    frame->number = sqlite3_column_int(s, 0);
    frame->state = frame_state(sqlite3_column_text(s, 1));
    job_record_digest(s, 2, &frame->exr);
    job_record_digest(s, 3, &frame->png);
    return 0;
}

static int copy_text(sqlite3_stmt *s, int column, const char **out)
{
    const unsigned char *text = sqlite3_column_text(s, column);
    *out = text ? strdup((const char *)text) : NULL;
    return text && !*out ? ERR_MEMORY : 0;
}

/* The new record is in *out even when a copy fails, so that fini finds it. */
int job_records_add(struct job_records *out, sqlite3_stmt *s)
{
    if (out->count == out->capacity) {
        size_t grown = out->capacity ? out->capacity * 2 : 8;
        struct job_record *items = realloc(out->items, grown * sizeof *items);
        if (!items) return ERR_MEMORY;
        out->items = items;
        out->capacity = grown;
    }
    struct job_record *job = &out->items[out->count++];
    *job = (struct job_record){0};
    job_record_id(s, 0, job->row.id);
    int error = copy_text(s, 1, &job->row.document);
    if (!error) error = copy_text(s, 2, &job->row.state);
    if (!error) error = copy_text(s, 3, &job->row.error);
    if (!error) error = copy_text(s, 4, &job->row.report);
    if (!error) error = copy_text(s, 11, &job->row.name);
    if (!error) error = copy_text(s, 12, &job->row.labels);
    job_record_digest(s, 13, &job->row.png);
    job->row.created_ms = sqlite3_column_int64(s, 5);
    job->row.updated_ms = sqlite3_column_int64(s, 6);
    job->row.priority = sqlite3_column_int(s, 7);
    job->row.paused = sqlite3_column_int(s, 8) != 0;
    short_text(s, 9, job->row.owner, sizeof job->row.owner);
    short_text(s, 10, job->row.trace, sizeof job->row.trace);
    return error;
}

void job_records_fini(struct job_records *records)
{
    for (size_t i = 0; i < records->count; i++) {
        struct job_row *row = &records->items[i].row;
        free((void *)(uintptr_t)row->document);
        free((void *)(uintptr_t)row->state);
        free((void *)(uintptr_t)row->error);
        free((void *)(uintptr_t)row->report);
        free((void *)(uintptr_t)row->name);
        free((void *)(uintptr_t)row->labels);
        free(records->items[i].frames);
    }
    free(records->items);
    *records = (struct job_records){0};
}
