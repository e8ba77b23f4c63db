#include "tests/unit/server/store/job_store_fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void close_store(struct fixture *f)
{
    job_store_close(&f->store);
    uv_run(&f->loop, UV_RUN_DEFAULT);
}

int setup(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    strcpy(f->dir, "/tmp/shearwater-jobs-XXXXXX");
    if (!mkdtemp(f->dir) || uv_loop_init(&f->loop)) return -1;
    *state = f;
    return open_store(f);
}

int teardown(void **state)
{
    struct fixture *f = *state;
    close_store(f);
    objects_remove_dir(f->dir);
    int error = uv_loop_close(&f->loop);
    free(f);
    return error;
}

struct job_row make_row(int number)
{
    struct job_row row = {.document = "{\"scene\":\"x\"}",
                          .state = "queued",
                          .created_ms = 1000 + number,
                          .updated_ms = 1000 + number,
                          .priority = number % 7 - 3};
    snprintf(row.id, sizeof row.id, "01JOB%021d", number);
    return row;
}

void on_inserted(void *ctx, int error, const char *existing)
{
    struct insertion *i = ctx;
    i->calls++;
    i->error = error;
    if (existing) strcpy(i->existing, existing);
}

int insert(struct fixture *f, int number, const char *key, const char *body, struct insertion *out)
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

void insert_plain(struct fixture *f, int number)
{
    struct insertion i;
    assert_int_equal(insert(f, number, NULL, "", &i), 0);
}

static void keep_text(char *out, size_t capacity, const char *text)
{
    snprintf(out, capacity, "%s", text ? text : "(null)");
}

static void on_found(void *ctx, int error, const struct job_row *row,
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

struct found get(struct fixture *f, const char *id)
{
    struct found found = {0};
    job_store_get(f->store, id, on_found, &found);
    settle(f);
    assert_int_equal(found.calls, 1);
    assert_int_equal(found.error, 0);
    return found;
}

void put_frame(struct fixture *f, int job, int32_t number, const char *state, bool finished)
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
