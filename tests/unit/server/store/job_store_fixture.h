#pragma once
/* A store of jobs in a folder of its own, which a test may close and open again. What is asked of
 * the store is answered when the loop has settled. */
#include <stdbool.h>

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

void close_store(struct fixture *f);
int setup(void **state);
int teardown(void **state);

static inline void settle(struct fixture *f)
{
    uv_run(&f->loop, UV_RUN_DEFAULT);
}

struct job_row make_row(int number);

struct insertion {
    int calls, error;
    char existing[JOB_ID_BYTES];
};

void on_inserted(void *ctx, int error, const char *existing);

static inline void on_done(void *ctx, int error)
{
    *(int *)ctx = error;
}

int insert(struct fixture *f, int number, const char *key, const char *body, struct insertion *out);
void insert_plain(struct fixture *f, int number);

struct found {
    int calls, error;
    bool there;
    struct job_row row; /* texts are not kept */
    char state[32], document[128], fault[128], report[128];
    struct frame_row frames[8];
    char frame_states[8][16];
    size_t frame_count;
};

struct found get(struct fixture *f, const char *id);
void put_frame(struct fixture *f, int job, int32_t number, const char *state, bool finished);
static const char first_id[] = "01JOB000000000000000000001";
