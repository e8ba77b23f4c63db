#pragma once
/* A store whose assets are given up. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/asset_removal.h"
#include "server/store/asset_tables.h"
#include "server/store/job_schema.h"
#include "tests/unit/unit.h"

struct fixture {
    char dir[64];
    uv_loop_t loop;
    uv_timer_t pause;
    struct objects objects;
    struct job_store *store;
    struct asset_room room;
    sqlite3 *db; /* beside the store's */
};

static inline int setup(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    /* In memory: passes rest in proportion to what they took, minutes where a disk is busy. */
    strcpy(f->dir, access("/dev/shm", W_OK) == 0 ? "/dev/shm/shearwater-removal-XXXXXX"
                                                 : "/tmp/shearwater-removal-XXXXXX");
    if (!mkdtemp(f->dir) || uv_loop_init(&f->loop) || objects_open(&f->objects, f->dir, false))
        return -1;
    *state = f;
    if (uv_timer_init(&f->loop, &f->pause)) return -1;
    if (job_store_open(&f->loop, f->dir, false, &f->store)) return -1;
    job_store_set_assets(f->store, &f->objects, 0);
    f->room.objects = &f->objects;
    char path[96];
    snprintf(path, sizeof path, "%s/jobs.sqlite", f->dir);
    return job_schema_open(path, false, &f->db);
}

static inline int teardown(void **state)
{
    struct fixture *f = *state;
    sqlite3_close(f->db);
    job_store_close(&f->store);
    uv_close((uv_handle_t *)&f->pause, NULL);
    uv_run(&f->loop, UV_RUN_DEFAULT);
    objects_remove_dir(f->dir);
    int error = uv_loop_close(&f->loop);
    free(f);
    return error;
}

static inline void settle(struct fixture *f)
{
    uv_run(&f->loop, UV_RUN_DEFAULT);
}

/* Stored, and held. */
static inline struct digest store(struct fixture *f, const char *text)
{
    struct object_writer *w;
    struct digest d;
    assert_int_equal(object_writer_begin(&f->objects, &w), 0);
    assert_int_equal(object_writer_append(w, text, strlen(text)), 0);
    assert_int_equal(object_writer_finish(&w, NULL, &d, NULL), 0);
    return d;
}

static inline void own(struct fixture *f, const char *owner, const struct digest *d)
{
    uint64_t size_bytes = 0;
    bool existed;
    (void)objects_have(&f->objects, d, &size_bytes);
    assert_int_equal(asset_owners_add(f->db, owner, d, size_bytes, &existed), 0);
}

static inline struct digest bring(struct fixture *f, const char *owner, const char *text)
{
    const struct digest d = store(f, text);
    own(f, owner, &d);
    objects_release(&f->objects, &d);
    return d;
}

static inline bool is_there(const struct fixture *f, const struct digest *d)
{
    return objects_have(&f->objects, d, NULL);
}

static inline bool is_noted(const struct fixture *f, const struct digest *d)
{
    return asset_removals_find(f->db, d) == 0;
}

static inline bool has(const struct fixture *f, const char *owner, const struct digest *d)
{
    return asset_owners_find(f->db, owner, d) == 0;
}

struct outcome {
    int error;
    struct asset_users users;
};

static inline void on_gave_up(void *ctx, int error, const struct asset_users *users)
{
    *(struct outcome *)ctx = (struct outcome){.error = error, .users = *users};
}

static inline int give_up(struct fixture *f, const char *owner, const struct digest *d)
{
    struct asset_claim claim = {.asset = *d};
    struct outcome outcome = {.error = 1};
    strcpy(claim.owner, owner);
    job_store_remove_asset(f->store, &claim, on_gave_up, &outcome);
    settle(f);
    return outcome.error;
}

static inline void on_inserted(void *ctx, int error, const char *existing)
{
    (void)existing;
    *(int *)ctx = error;
}

static inline void submit(struct fixture *f, const char *id, const char *key,
                          const struct digest *asset, int *error)
{
    char hex[DIGEST_HEX_BYTES], text[128];
    const struct digest body = {{7}};
    struct job_row row = {.document = text, .state = "queued", .owner = "a"};
    digest_to_hex(asset, hex);
    snprintf(text, sizeof text, "{\"scene\":{\"asset\":\"%s\"}}", hex);
    snprintf(row.id, sizeof row.id, "%s", id);
    job_store_submit(f->store, &row, key, &body, &(struct job_assets){.items = asset, .count = 1},
                     on_inserted, error);
}

static inline void on_done(void *ctx, int error)
{
    *(int *)ctx = error;
}

static inline void on_found(void *ctx, int error, const struct job_row *row,
                            const struct frame_row *frames, size_t frame_count)
{
    (void)frames, (void)frame_count;
    *(bool *)ctx = !error && row;
}

static inline void on_pause(uv_timer_t *pause)
{
    (void)pause;
}

/* The loop runs so long: timers that do not keep it alive come, too. */
static inline void let_pass(struct fixture *f, uint64_t ms)
{
    uv_timer_start(&f->pause, on_pause, ms, 0);
    settle(f);
}

/* It goes from the disk with its note: false after 20 s, longer under sanitizers. */
static inline bool goes(struct fixture *f, const struct digest *d)
{
    const char *slower = getenv("TEST_SLOWER"); /* tests/run */
    const int most = 400 * (slower ? atoi(slower) : 1);
    for (int i = 0; i < most && (is_there(f, d) || is_noted(f, d)); i++) let_pass(f, 50);
    return !is_there(f, d) && !is_noted(f, d);
}

/* A round over what is noted, here and now. Returns how many passes it took. */
static inline size_t pass(struct fixture *f)
{
    struct removal_pass pass = {0};
    size_t count = 0;
    do {
        asset_removal_pass(f->db, &f->room, &pass);
        count++;
    } while (pass.is_cut);
    return count;
}

static inline void remember(struct fixture *f, const char *source, const struct digest *blob,
                            const struct digest *assets, size_t count)
{
    struct digest d;
    int error = 1;
    digest_of(source, strlen(source), &d);
    job_store_remember_blob(f->store, &d, blob, assets, count, on_done, &error);
    settle(f);
    assert_int_equal(error, 0);
    objects_release(&f->objects, blob);
}
