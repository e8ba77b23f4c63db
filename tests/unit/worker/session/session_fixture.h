#pragma once
/* A worker's session with fake tracing, and its coordinator: a scripted one in the same thread, on
 * a real Unix socket. Waiting turns the worker's loop. */
#include <stdbool.h>

#include "proto/link/message.h"
#include "proto/link/wire_frame.h"
#include "proto/runtime/build.h"
#include "proto/scene/environment.h"
#include "tests/unit/proto/plan_case.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/session/fake_tracing.h"
#include "worker/session/session.h"

#define PATIENCE_MS 5000
#define BLOB_BYTES  (LIMIT_BLOB_PART_BYTES + 5000u)
#define MAP_BYTES   3000u
#define LIFE        (5ull << WORKER_ID_LIFE_SHIFT)

struct world {
    uv_loop_t loop;
    char dir[64], address[100], cache[100], blobs[100];
    struct options options;
    struct session *session;
    bool ended, closed;
    enum session_end end;
    char text[LIMIT_DETAIL_BYTES];
    struct worker_log worker_log; /* to a file in dir */
    int listener, fd;
    struct wire_frame_inbox inbox;
    struct bytes_writer w;
    struct plan plan;
    uint8_t *blob;
    uint8_t map[MAP_BYTES]; /* of an environment */
    struct digest map_digest;
    uint32_t asked; /* tiles that the worker wants, as far as we read */
};

/* Does the worker's log have a line with all of that? */
bool told(const struct world *w, const char *what, const char *detail);

void on_ended(void *ctx, enum session_end end, const char *text);
void on_closed(void *ctx);
void turn(struct world *w);
struct world *world_open(uint32_t threads, bool with_blobs);
/* The same with the deadlines of `deadlines`. */
struct world *world_open_with(uint32_t threads, bool with_blobs, const struct options *deadlines);
void world_close(struct world *w);
void accept_link(struct world *w);
void drop_link(struct world *w);
void put(struct world *w, uint16_t type, const void *tail, uint32_t tail_bytes);
bool read_some(struct world *w);

/* The next frame but beats and wants. False: the worker closed the link, or nothing came. */
bool next(struct world *w, struct wire_frame_view *f, int patience_ms);

void expect(struct world *w, uint16_t type, struct wire_frame_view *f);
void expect_nothing(struct world *w);
void welcome(struct world *w, uint64_t worker_id);
void send_frame(struct world *w, uint64_t id);
void send_pass(struct world *w, uint64_t frame_id, uint32_t index, uint32_t pass);

static inline void send_tile(struct world *w, uint64_t frame_id, uint32_t index)
{
    send_pass(w, frame_id, index, 0);
}

/* Welcomes worker 1 and gives it a tile of frame 9. */
void start_tile(struct world *w, uint32_t index);

void send_ack(struct world *w, uint64_t frame_id, uint32_t index);

/* Answers a question for a part of the scene or the map. Returns the offset behind the part. */
uint64_t answer(struct world *w, const struct message_blob_get *get);

void expect_get(struct world *w, struct message_blob_get *get);
void serve_blob(struct world *w);
void give_map(struct world *w);
uint32_t expect_result(struct world *w);

/* Expects a tile's fault with `part` in its text, and returns the tile's index. */
uint32_t expect_fault(struct world *w, int code, const char *part);

/* A scene in hand and tile 0 answered. */
void warm_up(struct world *w);
