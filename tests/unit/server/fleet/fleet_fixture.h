#pragma once
/* A fleet on a real Unix socket, and its client, a scripted one: hands out tiles by number, notes
 * what comes back. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/log/log.h"
#include "server/fleet/fleet.h"
#include "tests/unit/unit.h"

#define SOCKET_DIR  "/tmp/shearwater-test-fleet-%ld" /* of this process; goes with its world */
#define PATIENCE_MS 5000
#define LONG_MS     60000 /* none of it takes so long, however busy the machine */

struct world {
    uv_loop_t loop;
    struct fleet *fleet;
    bool closed;
    char socket_path[100], blob_path[100];
    /* Script. */
    uint32_t tiles;      /* still to be handed out */
    uint32_t verdict;    /* of results; 0: acknowledged later */
    uint32_t generation; /* of the tiles */
    /* Notes. */
    uint32_t next_index, results, returned, faulted;
    uint64_t worker;
    struct fleet_tile last_returned;
    enum fleet_return why;
    uint8_t *bytes[256]; /* results taken over */
    uint32_t size_bytes;
    uint8_t first_byte;
};

static inline bool next_tile(void *ctx, const struct worker_request *request,
                             struct fleet_tile *out)
{
    struct world *w = ctx;
    assert_int_equal(request->capabilities, CAPABILITY_DIRECT);
    if (w->tiles == 0) return false;
    w->tiles--;
    w->worker = request->worker;
    *out = (struct fleet_tile){.frame_id = 7,
                               .index = w->next_index++,
                               .generation = w->generation,
                               .pass = {.number = 41, .first = 1000, .count = 20, .strata = 4},
                               .rect = {0, 0, 32, 32}};
    return true;
}

static inline bool plan(void *ctx, uint64_t frame_id, struct message_frame_plan *out)
{
    static const uint8_t bytes[] = "the plan";
    (void)ctx;
    assert_int_equal(frame_id, 7);
    *out = (struct message_frame_plan){
        .frame_id = frame_id, .job = "a job", .plan = bytes, .plan_bytes = sizeof bytes};
    return true;
}

static inline uint32_t result(void *ctx, uint64_t worker, const struct message_result *r,
                              uint8_t **bytes, uint32_t size_bytes)
{
    struct world *w = ctx;
    assert_int_equal(worker, w->worker);
    assert_ptr_equal(r->samples, *bytes);
    w->size_bytes = size_bytes;
    w->first_byte = size_bytes ? (*bytes)[0] : 0;
    if (w->verdict == 0) {
        assert_true(w->results < 256);
        w->bytes[w->results] = *bytes;
        *bytes = NULL;
    }
    w->results++;
    return w->verdict;
}

static inline void returned(void *ctx, uint64_t worker, const struct fleet_tile *tile,
                            enum fleet_return why)
{
    struct world *w = ctx;
    (void)worker;
    w->returned++;
    w->last_returned = *tile;
    w->why = why;
}

static inline void faulted(void *ctx, uint64_t worker, const struct message_tile_fault *fault)
{
    struct world *w = ctx;
    (void)worker;
    assert_string_equal(fault->text, "no such thing");
    w->faulted++;
    fleet_cancel(w->fleet, fault->frame_id); /* a client does so from inside */
}

static inline bool blob_path(void *ctx, const struct digest *digest, char *out, size_t capacity)
{
    struct world *w = ctx;
    if (digest->bytes[0] != 1) return false;
    snprintf(out, capacity, "%s", w->blob_path);
    return true;
}

static const struct fleet_client client_of_world = {.next_tile = next_tile,
                                                    .plan = plan,
                                                    .result = result,
                                                    .returned = returned,
                                                    .faulted = faulted,
                                                    .blob_path = blob_path};

static inline void on_closed(void *ctx)
{
    struct world *w = ctx;
    w->closed = true;
}

static inline struct world *world_open_with(const struct fleet_options *options)
{
    struct world *w = calloc(1, sizeof *w);
    struct fleet_client client = client_of_world;
    struct fault fault = {0};
    snprintf(w->socket_path, sizeof w->socket_path, "%s", options->socket_path);
    snprintf(w->blob_path, sizeof w->blob_path, SOCKET_DIR "/blob", (long)getpid());
    uv_loop_init(&w->loop);
    client.ctx = w;
    w->generation = 1;
    if (fleet_create(&w->loop, options, &client, &w->fleet, &fault) != 0)
        fail_msg("%s: %s", fault.pointer, fault.detail);
    return w;
}

static inline void make_socket_dir(void)
{
    char path[100];
    snprintf(path, sizeof path, SOCKET_DIR, (long)getpid());
    mkdir(path, 0700);
}

static inline struct world *world_open_logged(uint32_t silence_ms, uint32_t stall_ms,
                                              struct log *log)
{
    char path[100];
    static int worlds; /* a test that failed leaves its socket open */
    make_socket_dir();
    snprintf(path, sizeof path, SOCKET_DIR "/%d.sock", (long)getpid(), ++worlds);
    const struct fleet_options options = {.socket_path = path,
                                          .listen = "127.0.0.1:0",
                                          .log = log,
                                          .beat_ms = 50,
                                          .silence_ms = silence_ms,
                                          .stall_ms = stall_ms};
    return world_open_with(&options);
}

static inline struct world *world_open(uint32_t silence_ms, uint32_t stall_ms)
{
    return world_open_logged(silence_ms, stall_ms, NULL);
}

static inline void world_close(struct world *w)
{
    fleet_close(w->fleet, on_closed, w);
    while (!w->closed) uv_run(&w->loop, UV_RUN_ONCE);
    uv_run(&w->loop, UV_RUN_NOWAIT);
    assert_int_equal(uv_loop_close(&w->loop), 0);
    for (uint32_t i = 0; i < 256; i++) free(w->bytes[i]);
    unlink(w->blob_path);
    *strrchr(w->blob_path, '/') = '\0';
    rmdir(w->blob_path);
    free(w);
}

static inline void turn(struct world *w)
{
    uv_run(&w->loop, UV_RUN_NOWAIT);
    usleep(500);
    uv_update_time(&w->loop);
}

static inline struct fleet_totals totals(const struct world *w)
{
    struct fleet_totals t;
    fleet_totals(w->fleet, &t);
    return t;
}
