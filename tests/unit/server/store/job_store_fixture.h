#pragma once
/* A store of jobs in a folder of its own, which a test may close and open again. What is asked of
 * the store is answered when the loop has settled. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/job_store.h"
#include "server/store/objects.h"
#include "tests/unit/unit.h"

struct fixture {
    char dir[64];
    uv_loop_t loop;
    struct job_store *store;
};

static inline int open_store(struct fixture *f)
{
    return job_store_open(&f->loop, f->dir, false, &f->store);
}

static inline void close_store(struct fixture *f)
{
    job_store_close(&f->store);
    uv_run(&f->loop, UV_RUN_DEFAULT);
}

static inline int setup(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    strcpy(f->dir, "/tmp/shearwater-jobs-XXXXXX");
    if (!mkdtemp(f->dir) || uv_loop_init(&f->loop)) return -1;
    *state = f;
    return open_store(f);
}

static inline int teardown(void **state)
{
    struct fixture *f = *state;
    close_store(f);
    objects_remove_dir(f->dir);
    int error = uv_loop_close(&f->loop);
    free(f);
    return error;
}

static inline void settle(struct fixture *f)
{
    uv_run(&f->loop, UV_RUN_DEFAULT);
}

static inline struct job_row make_row(int number)
{
    struct job_row row = {.document = "{\"scene\":\"x\"}",
                          .state = "queued",
                          .created_ms = 1000 + number,
                          .updated_ms = 1000 + number,
                          .priority = number % 7 - 3};
    snprintf(row.id, sizeof row.id, "01JOB%021d", number);
    return row;
}

struct insertion {
    int calls, error;
    char existing[JOB_ID_BYTES];
};

static inline void on_inserted(void *ctx, int error, const char *existing)
{
    struct insertion *i = ctx;
    i->calls++;
    i->error = error;
    if (existing) strcpy(i->existing, existing);
}

static inline void on_done(void *ctx, int error)
{
    *(int *)ctx = error;
}

static inline int insert(struct fixture *f, int number, const char *key, const char *body,
                         struct insertion *out)
{
    struct job_row row = make_row(number);
    struct digest digest;
    *out = (struct insertion){.error = 1};
    digest_of(body, strlen(body), &digest);
    job_store_insert(f->store, &row, key, &digest, on_inserted, out);
    settle(f);
    assert_int_equal(out->calls, 1);
    return out->error;
}

static inline void insert_plain(struct fixture *f, int number)
{
    struct insertion i;
    assert_int_equal(insert(f, number, NULL, "", &i), 0);
}

struct found {
    int calls, error;
    bool there;
    struct job_row row; /* texts are not kept */
    char state[32], document[128], fault[128], report[128];
    struct frame_row frames[8];
    char frame_states[8][16];
    size_t frame_count;
};

static inline void keep_text(char *out, size_t capacity, const char *text)
{
    snprintf(out, capacity, "%s", text ? text : "(null)");
}

static inline void on_found(void *ctx, int error, const struct job_row *row,
                            const struct frame_row *frames, size_t frame_count)
{
    struct found *f = ctx;
    f->calls++;
    f->error = error;
    f->there = row != NULL;
    if (!row) return;
    f->row = *row;
    keep_text(f->state, sizeof f->state, row->state);
    keep_text(f->document, sizeof f->document, row->document);
    keep_text(f->fault, sizeof f->fault, row->error);
    keep_text(f->report, sizeof f->report, row->report);
    f->frame_count = frame_count;
    for (size_t i = 0; i < frame_count && i < 8; i++) {
        f->frames[i] = frames[i];
        keep_text(f->frame_states[i], sizeof f->frame_states[i], frames[i].state);
    }
}

static inline struct found get(struct fixture *f, const char *id)
{
    struct found found = {0};
    job_store_get(f->store, id, on_found, &found);
    settle(f);
    assert_int_equal(found.calls, 1);
    assert_int_equal(found.error, 0);
    return found;
}

static inline void put_frame(struct fixture *f, int job, int32_t number, const char *state,
                             bool finished)
{
    struct frame_row frame = {.number = number, .state = state};
    int error = 1;
    if (finished) {
        digest_of("exr", 3, &frame.exr);
        digest_of("png", 3, &frame.png);
    }
    job_store_update_frame(f->store, make_row(job).id, &frame, NULL, on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
}

static const char first_id[] = "01JOB000000000000000000001";
