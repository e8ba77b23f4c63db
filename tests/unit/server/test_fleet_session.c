/* The fleet over a real Unix socket, with a scripted peer and a scripted client in the same thread.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "proto/build.h"
#include "proto/frame.h"
#include "server/fleet/fleet.h"
#include "server/fleet/session.h"

#define SOCKET_DIR  "/tmp/shearwater-test-fleet"
#define PATIENCE_MS 5000
#define LONG_MS     60000 /* none of it takes so long, however busy the machine */

/* ---- the fleet's client: hands out tiles by number, notes what comes back ---- */

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

static bool next_tile(void *ctx, const struct fleet_asker *asker, struct fleet_tile *out)
{
    struct world *w = ctx;
    assert_int_equal(asker->capabilities, CAPABILITY_DIRECT);
    if (w->tiles == 0) return false;
    w->tiles--;
    w->worker = asker->worker;
    *out = (struct fleet_tile){.frame_id = 7,
                               .index = w->next_index++,
                               .generation = w->generation,
                               .pass = {41, 1000, 20, 4},
                               .rect = {0, 0, 32, 32}};
    return true;
}

static bool plan(void *ctx, uint64_t frame_id, struct message_frame_plan *out)
{
    static const uint8_t bytes[] = "the plan";
    (void)ctx;
    assert_int_equal(frame_id, 7);
    *out = (struct message_frame_plan){
        .frame_id = frame_id, .job = "a job", .plan = bytes, .plan_bytes = sizeof bytes};
    return true;
}

static uint32_t result(void *ctx, uint64_t worker, const struct message_result *r, uint8_t **bytes,
                       uint32_t size_bytes)
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

static void returned(void *ctx, uint64_t worker, const struct fleet_tile *tile,
                     enum fleet_return why)
{
    struct world *w = ctx;
    (void)worker;
    w->returned++;
    w->last_returned = *tile;
    w->why = why;
}

static void faulted(void *ctx, uint64_t worker, const struct message_tile_fault *fault)
{
    struct world *w = ctx;
    (void)worker;
    assert_string_equal(fault->text, "no such thing");
    w->faulted++;
    fleet_cancel(w->fleet, fault->frame_id); /* a client does so from inside */
}

static bool blob_path(void *ctx, const struct digest *digest, char *out, size_t capacity)
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

static void on_closed(void *ctx)
{
    struct world *w = ctx;
    w->closed = true;
}

static struct world *world_open_with(const struct fleet_options *options)
{
    struct world *w = calloc(1, sizeof *w);
    struct fleet_client client = client_of_world;
    struct fault fault = {0};
    snprintf(w->socket_path, sizeof w->socket_path, "%s", options->socket_path);
    snprintf(w->blob_path, sizeof w->blob_path, SOCKET_DIR "/%ld.blob", (long)getpid());
    uv_loop_init(&w->loop);
    client.ctx = w;
    w->generation = 1;
    if (fleet_create(&w->loop, options, &client, &w->fleet, &fault) != 0)
        fail_msg("%s: %s", fault.pointer, fault.detail);
    return w;
}

static struct world *world_open(uint32_t silence_ms, uint32_t stall_ms)
{
    char path[100];
    mkdir(SOCKET_DIR, 0700);
    static int worlds; /* a test that failed leaves its socket open */
    snprintf(path, sizeof path, SOCKET_DIR "/%ld.%d.sock", (long)getpid(), ++worlds);
    const struct fleet_options options = {.socket_path = path,
                                          .listen = "127.0.0.1:0",
                                          .beat_ms = 50,
                                          .silence_ms = silence_ms,
                                          .stall_ms = stall_ms};
    return world_open_with(&options);
}

static void world_close(struct world *w)
{
    fleet_close(w->fleet, on_closed, w);
    while (!w->closed) uv_run(&w->loop, UV_RUN_ONCE);
    uv_run(&w->loop, UV_RUN_NOWAIT);
    assert_int_equal(uv_loop_close(&w->loop), 0);
    for (uint32_t i = 0; i < 256; i++) free(w->bytes[i]);
    unlink(w->blob_path);
    free(w);
}

/* ---- the peer: a nonblocking socket; waiting turns the fleet's loop ---- */

struct peer {
    struct world *world;
    int fd;
    struct frame_inbox inbox;
    struct bytes_writer w;
};

static void turn(struct world *w)
{
    uv_run(&w->loop, UV_RUN_NOWAIT);
    usleep(500);
    uv_update_time(&w->loop);
}

static struct peer peer_open(struct world *w)
{
    struct peer p = {.world = w};
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    memcpy(a.sun_path, w->socket_path, strlen(w->socket_path) + 1);
    p.fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(p.fd, (struct sockaddr *)&a, sizeof a), 0);
    fcntl(p.fd, F_SETFL, O_NONBLOCK);
    frame_inbox_init(&p.inbox, LIMIT_FRAME_BYTES);
    bytes_writer_init(&p.w);
    return p;
}

static void peer_close(struct peer *p)
{
    close(p->fd);
    frame_inbox_fini(&p->inbox);
    bytes_writer_fini(&p->w);
}

/* False when the fleet closes the link while we write. */
static bool peer_send_raw(struct peer *p, const void *data, size_t size_bytes)
{
    const uint8_t *at = data;
    for (int waited = 0; size_bytes > 0 && waited < PATIENCE_MS; waited++) {
        ssize_t n = send(p->fd, at, size_bytes, MSG_NOSIGNAL);
        if (n < 0 && errno != EAGAIN) return false;
        if (n > 0) at += n, size_bytes -= (size_t)n;
        if (n < 0) turn(p->world);
    }
    return size_bytes == 0;
}

static bool peer_send(struct peer *p, uint16_t type, uint64_t id, const void *tail,
                      uint32_t tail_bytes)
{
    uint8_t header[FRAME_HEADER_BYTES];
    assert_false(p->w.failed);
    frame_header(header, type, id, p->w.data, (uint32_t)p->w.size_bytes, tail, tail_bytes);
    bool sent = peer_send_raw(p, header, sizeof header) &&
                peer_send_raw(p, p->w.data, p->w.size_bytes) && peer_send_raw(p, tail, tail_bytes);
    p->w.size_bytes = 0;
    return sent;
}

/* Reads what is there: false when the fleet closed the link. */
static bool peer_read(struct peer *p)
{
    size_t space_bytes = 0;
    uint8_t *space = frame_inbox_space(&p->inbox, &space_bytes);
    ssize_t n = recv(p->fd, space, space_bytes, 0);
    if (n == 0 || (n < 0 && errno != EAGAIN)) return false;
    if (n > 0) frame_inbox_filled(&p->inbox, (size_t)n);
    return true;
}

static void peer_expect(struct peer *p, uint16_t type, struct frame_view *f)
{
    for (int waited = 0; waited < PATIENCE_MS; waited++) {
        int e = frame_inbox_next(&p->inbox, f);
        if (e == 0) {
            if (f->type != type)
                fail_msg("%s, expected %s", message_name(f->type), message_name(type));
            return;
        }
        assert_int_equal(e, ERR_INCOMPLETE);
        turn(p->world);
        if (!peer_read(p)) fail_msg("closed, expected %s", message_name(type));
    }
    fail_msg("nothing, expected %s", message_name(type));
}

static void peer_expect_nothing(struct peer *p)
{
    struct frame_view f;
    for (int i = 0; i < 40; i++) {
        turn(p->world);
        assert_true(peer_read(p));
    }
    assert_int_equal(frame_inbox_next(&p->inbox, &f), ERR_INCOMPLETE);
}

static int peer_expect_close(struct peer *p)
{
    for (int waited = 0; waited < 2 * PATIENCE_MS; waited++) {
        turn(p->world);
        if (!peer_read(p)) return waited;
    }
    fail_msg("not closed");
    return 0;
}

static void fill_hello(struct message_hello *m)
{
    *m = (struct message_hello){.protocol_version = PROTOCOL_VERSION,
                                .capabilities = CAPABILITY_DIRECT,
                                .embree_version = "3.13.5",
                                .name = "peer",
                                .threads = 2,
                                .pid = 1};
    snprintf(m->build_id, sizeof m->build_id, "%s", build_id());
    snprintf(m->isa, sizeof m->isa, "%s", build_isa());
}

static void peer_hello(struct peer *p)
{
    struct message_hello m;
    fill_hello(&m);
    message_encode_hello(&p->w, &m);
    assert_true(peer_send(p, MESSAGE_HELLO, 1, NULL, 0));
}

static uint64_t peer_join(struct peer *p)
{
    struct frame_view f;
    struct message_welcome m;
    peer_hello(p);
    peer_expect(p, MESSAGE_WELCOME, &f);
    assert_int_equal(message_decode_welcome(f.payload, f.payload_bytes, &m), 0);
    assert_int_equal(m.beat_ms, 50);
    return m.worker_id;
}

static void peer_want(struct peer *p, uint32_t tiles)
{
    message_encode_want(&p->w, &(struct message_want){.tiles = tiles});
    assert_true(peer_send(p, MESSAGE_WANT, 2, NULL, 0));
}

static void peer_tile(struct peer *p, struct message_tile *m)
{
    struct frame_view f;
    peer_expect(p, MESSAGE_TILE, &f);
    assert_int_equal(message_decode_tile(f.payload, f.payload_bytes, m), 0);
}

static bool peer_result(struct peer *p, const struct message_tile *tile, uint32_t size_bytes)
{
    uint8_t *samples = malloc(size_bytes + 1);
    memset(samples, 0xab, size_bytes + 1);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = size_bytes};
    message_encode_result(&p->w, &m);
    bool sent = peer_send(p, MESSAGE_RESULT, 99, samples, size_bytes);
    free(samples);
    return sent;
}

static uint32_t peer_verdict(struct peer *p)
{
    struct frame_view f;
    struct message_ack m;
    peer_expect(p, MESSAGE_ACK, &f);
    assert_int_equal(message_decode_ack(f.payload, f.payload_bytes, &m), 0);
    return m.verdict;
}

static bool peer_beat(struct peer *p, uint64_t progress)
{
    message_encode_beat(&p->w, &(struct message_beat){.progress = progress,
                                                      .phase = BEAT_TRACING,
                                                      .peak_rss_bytes = 4096});
    return peer_send(p, MESSAGE_BEAT, 3, NULL, 0);
}

static void peer_expect_refusal(struct peer *p, const char *says)
{
    struct frame_view f;
    struct message_refused m;
    peer_expect(p, MESSAGE_REFUSED, &f);
    assert_int_equal(message_decode_refused(f.payload, f.payload_bytes, &m), 0);
    if (!strstr(m.text, says)) fail_msg("\"%s\" does not say \"%s\"", m.text, says);
    peer_expect_close(p);
}

static struct fleet_totals totals(const struct world *w)
{
    struct fleet_totals t;
    fleet_totals(w->fleet, &t);
    return t;
}

/* ---- tests ---- */

static void a_tile_goes_out_and_its_result_in(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile;
    uint64_t id = peer_join(&p);
    assert_int_equal(fleet_count(w->fleet), 1);
    w->tiles = 3;
    w->verdict = VERDICT_ACCEPTED;
    peer_want(&p, 2);
    peer_expect(&p, MESSAGE_FRAME, &f); /* once, before the first tile */
    peer_tile(&p, &tile);
    assert_int_equal(tile.index, 0);
    assert_int_equal(tile.pass.number, 41);
    assert_int_equal(tile.pass.first, 1000);
    assert_int_equal(tile.pass.count, 20);
    assert_int_equal(tile.pass.strata, 4);
    assert_int_equal(tile.counts_bytes, 0);
    assert_int_equal(w->worker, id);
    peer_tile(&p, &tile);
    peer_expect_nothing(&p); /* it wanted two */
    assert_true(peer_result(&p, &tile, 1000));
    assert_int_equal(peer_verdict(&p), VERDICT_ACCEPTED);
    assert_int_equal(w->size_bytes, 1000);
    assert_int_equal(w->first_byte, 0xab);
    peer_want(&p, 1);
    peer_tile(&p, &tile);
    json_t *roster = fleet_roster(w->fleet);
    json_t *entry = json_array_get(roster, 0);
    assert_int_equal(json_integer_value(json_object_get(entry, "tiles_in_hand")), 2);
    assert_int_equal(json_integer_value(json_object_get(entry, "tiles_done")), 1);
    assert_string_equal(json_string_value(json_object_get(entry, "state")), "working");
    json_decref(roster);
    peer_close(&p);
    while (w->returned < 2) turn(w);
    world_close(w);
}

static void waiting_workers_are_served_on_a_wake(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile;
    peer_join(&p);
    peer_want(&p, 4);
    peer_expect_nothing(&p);
    w->tiles = 1;
    fleet_wake(w->fleet);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_tile(&p, &tile);
    peer_close(&p);
    world_close(w);
}

static void late_verdicts_and_cancelled_frames(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile, other;
    peer_join(&p);
    w->tiles = 2;
    peer_want(&p, 2);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_tile(&p, &tile);
    peer_tile(&p, &other);
    assert_true(peer_result(&p, &tile, 10));
    peer_expect_nothing(&p);
    assert_int_equal(w->results, 1);
    const struct message_ack ack = {.frame_id = tile.frame_id,
                                    .index = tile.index,
                                    .generation = tile.generation,
                                    .verdict = VERDICT_CORRUPT};
    fleet_ack(w->fleet, w->worker, &ack);
    assert_int_equal(peer_verdict(&p), VERDICT_CORRUPT);
    assert_int_equal(totals(w).corrupt, 1);
    fleet_cancel(w->fleet, tile.frame_id);
    peer_expect(&p, MESSAGE_CANCEL, &f);
    assert_true(peer_result(&p, &other, 10)); /* it crossed the CANCEL */
    assert_int_equal(peer_verdict(&p), VERDICT_FOREIGN);
    assert_int_equal(w->results, 1);
    assert_int_equal(w->returned, 0);
    peer_close(&p);
    world_close(w);
}

static void mismatches_are_refused_with_advice(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer good = peer_open(w);
    peer_join(&good);
    for (int i = 0; i < 4; i++) {
        struct peer p = peer_open(w);
        struct message_hello m;
        fill_hello(&m);
        if (i == 0) snprintf(m.build_id, sizeof m.build_id, "0.0.1+other");
        if (i == 1) m.protocol_version = 77;
        if (i == 2) snprintf(m.isa, sizeof m.isa, "%s", strcmp(m.isa, "avx2") ? "avx2" : "sse4.2");
        if (i == 3) snprintf(m.embree_version, sizeof m.embree_version, "3.12.0");
        message_encode_hello(&p.w, &m);
        assert_true(peer_send(&p, MESSAGE_HELLO, 1, NULL, 0));
        static const char *const says[] = {"install the same build on both machines",
                                           "install the same build",
                                           "SHEARWATER_ISA=", "install the same Embree"};
        peer_expect_refusal(&p, says[i]);
        peer_close(&p);
    }
    assert_int_equal(totals(w).refused, 4);
    assert_int_equal(fleet_count(w->fleet), 1);
    peer_close(&good);
    world_close(w);
}

/* A HELLO of another version, whatever follows the number. */
static void an_unknown_hello_is_refused(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    bytes_write_u32(&p.w, 1234);
    bytes_write_u64(&p.w, 0x1122334455667788u);
    assert_true(peer_send(&p, MESSAGE_HELLO, 1, NULL, 0));
    peer_expect_refusal(&p, "protocol 1234");
    peer_close(&p);
    world_close(w);
}

static void out_of_state_and_damaged_messages_end_the_session(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    for (int i = 0; i < 6; i++) {
        struct peer p = peer_open(w);
        uint8_t big[LIMIT_HELLO_BYTES + 100] = {0};
        if (i >= 3) peer_join(&p);
        switch (i) {
        case 0: /* before HELLO */
            message_encode_want(&p.w, &(struct message_want){.tiles = 1});
            peer_send(&p, MESSAGE_WANT, 1, NULL, 0);
            break;
        case 1: /* too large for a HELLO */
            peer_send(&p, MESSAGE_HELLO, 1, big, sizeof big);
            break;
        case 2:
            peer_send_raw(&p, "GET / HTTP/1.1\r\n\r\n", 18);
            break;
        case 3: /* twice */
            peer_hello(&p);
            break;
        case 4: /* a coordinator's message */
            message_encode_drain(&p.w, &(struct message_drain){0});
            peer_send(&p, MESSAGE_DRAIN, 1, NULL, 0);
            break;
        default: /* short */
            bytes_write_u8(&p.w, 1);
            peer_send(&p, MESSAGE_RESULT, 1, NULL, 0);
        }
        peer_expect_close(&p);
        peer_close(&p);
    }
    assert_int_equal(totals(w).corrupt, 6);
    assert_int_equal(fleet_count(w->fleet), 0);
    world_close(w);
}

static void foreign_and_old_results_do_not_pass_as_leases(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile, other;
    peer_join(&p);
    w->tiles = 1;
    w->generation = 5;
    w->verdict = VERDICT_STALE;
    peer_want(&p, 1);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_tile(&p, &tile);
    other = tile;
    other.index += 100;
    assert_true(peer_result(&p, &other, 10));
    assert_int_equal(peer_verdict(&p), VERDICT_FOREIGN);
    assert_int_equal(w->results, 0); /* the client was not asked */
    other = tile;
    other.generation = 4;
    assert_true(peer_result(&p, &other, 10));
    assert_int_equal(peer_verdict(&p), VERDICT_STALE);
    assert_int_equal(w->results, 1); /* it was */
    w->verdict = VERDICT_ACCEPTED;
    assert_true(peer_result(&p, &tile, 10));
    assert_int_equal(peer_verdict(&p), VERDICT_ACCEPTED);
    w->verdict = VERDICT_DUPLICATE;
    assert_true(peer_result(&p, &tile, 10));
    assert_int_equal(peer_verdict(&p), VERDICT_DUPLICATE);
    struct fleet_totals t = totals(w);
    assert_int_equal(t.foreign, 1);
    assert_int_equal(t.stale, 1);
    assert_int_equal(t.duplicate, 1);
    assert_int_equal(w->returned, 0);
    peer_close(&p);
    world_close(w);
}

static void given_back_and_faulted_tiles_reach_the_client(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile;
    peer_join(&p);
    w->tiles = 2;
    peer_want(&p, 2);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_tile(&p, &tile);
    message_encode_returned(&p.w, &(struct message_returned){.frame_id = tile.frame_id,
                                                             .index = tile.index,
                                                             .generation = tile.generation});
    assert_true(peer_send(&p, MESSAGE_RETURN, 1, NULL, 0));
    peer_tile(&p, &tile);
    struct message_tile_fault m = {.frame_id = tile.frame_id,
                                   .index = tile.index,
                                   .generation = tile.generation,
                                   .code = ERR_NOT_FOUND,
                                   .text = "no such thing"};
    message_encode_tile_fault(&p.w, &m);
    assert_true(peer_send(&p, MESSAGE_FAULT, 1, NULL, 0));
    peer_expect(&p, MESSAGE_CANCEL, &f); /* faulted() cancels */
    assert_int_equal(w->returned, 1);
    assert_int_equal(w->faulted, 1);
    message_encode_bye(&p.w, &(struct message_bye){0});
    assert_true(peer_send(&p, MESSAGE_BYE, 1, NULL, 0));
    peer_expect_close(&p);
    peer_close(&p);
    world_close(w);
}

static void silence_ends_a_session(void **state)
{
    (void)state;
    struct world *w = world_open(200, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    peer_join(&p);
    w->tiles = 1;
    peer_want(&p, 1);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_expect_close(&p);
    assert_int_equal(w->returned, 1);
    assert_int_equal(w->why, FLEET_TAKEN_BACK);
    assert_int_equal(fleet_count(w->fleet), 0);
    peer_close(&p);
    world_close(w);
}

static void a_late_hello_is_not_awaited(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    uint64_t before = uv_hrtime();
    peer_expect_close(&p);
    uint64_t ms = (uv_hrtime() - before) / 1000000u;
    assert_in_range(ms, SESSION_HELLO_MS - 200, SESSION_HELLO_MS + 2000);
    peer_close(&p);
    world_close(w);
}

static void a_stalled_tile_is_taken_back(void **state)
{
    (void)state;
    /* Far longer than a turn may take while others use the machine. */
    struct world *w = world_open(LONG_MS, 1000);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile;
    peer_join(&p);
    w->tiles = 2;
    peer_want(&p, 1);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_tile(&p, &tile);
    uint64_t progress = 0;
    for (uint64_t end = uv_hrtime() + 1500000000u; uv_hrtime() < end;) {
        peer_beat(&p, ++progress); /* keeps it */
        turn(w);
        assert_int_equal(w->returned, 0);
    }
    peer_want(&p, 1);
    peer_tile(&p, &tile);
    for (int i = 0; w->returned < 2 && i < 2 * PATIENCE_MS; i++) {
        if (i % 50 == 0) peer_beat(&p, progress);
        turn(w);
    }
    assert_int_equal(w->returned, 2);
    assert_int_equal(fleet_count(w->fleet), 0); /* no more for it until it moves */
    w->tiles = 1;
    peer_want(&p, 1);
    peer_expect_nothing(&p);
    w->verdict = VERDICT_STALE;
    assert_true(peer_result(&p, &tile, 10)); /* too late: the client judges */
    assert_int_equal(peer_verdict(&p), VERDICT_STALE);
    peer_beat(&p, progress + 1);
    peer_tile(&p, &tile);
    assert_int_equal(fleet_count(w->fleet), 1);
    peer_close(&p);
    world_close(w);
}

static void unacknowledged_results_stop_the_reading(void **state)
{
    (void)state;
    enum { BYTES = 12 << 20, TILES = 4 };
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile[TILES];
    peer_join(&p);
    w->tiles = TILES;
    peer_want(&p, TILES);
    peer_expect(&p, MESSAGE_FRAME, &f);
    for (int i = 0; i < TILES; i++) peer_tile(&p, &tile[i]);
    for (int i = 0; i < 3; i++) assert_true(peer_result(&p, &tile[i], BYTES));
    for (int i = 0; w->results < 3 && i < PATIENCE_MS; i++) turn(w);
    assert_int_equal(w->results, 3); /* 36 MiB: over the bound */
    uint8_t *samples = calloc(1, BYTES);
    const struct message_result m = {
        .frame_id = 7, .index = 3, .generation = 1, .samples_bytes = BYTES};
    message_encode_result(&p.w, &m);
    uint8_t header[FRAME_HEADER_BYTES];
    frame_header(header, MESSAGE_RESULT, 1, p.w.data, (uint32_t)p.w.size_bytes, samples, BYTES);
    bytes_write_raw(&p.w, samples, BYTES);
    ssize_t n = send(p.fd, header, sizeof header, MSG_NOSIGNAL);
    assert_int_equal(n, sizeof header);
    size_t at = 0;
    for (int i = 0; i < 200; i++) { /* the kernel's buffer fills, nobody reads */
        n = send(p.fd, p.w.data + at, p.w.size_bytes - at, MSG_NOSIGNAL);
        if (n > 0) at += (size_t)n;
        turn(w);
    }
    assert_true(at < p.w.size_bytes);
    struct message_ack ack = {.frame_id = 7, .generation = 1, .verdict = VERDICT_ACCEPTED};
    fleet_ack(w->fleet, w->worker, &ack);
    assert_true(peer_send_raw(&p, p.w.data + at, p.w.size_bytes - at));
    for (int i = 0; w->results < 4 && i < PATIENCE_MS; i++) turn(w);
    assert_int_equal(w->results, 4);
    free(samples);
    peer_close(&p);
    world_close(w);
}

static void blobs_are_served_in_parts(void **state)
{
    (void)state;
    enum { BYTES = LIMIT_BLOB_PART_BYTES + 1000 };
    struct world *w = world_open(LONG_MS, LONG_MS);
    uint8_t *blob = malloc(BYTES);
    for (size_t i = 0; i < BYTES; i++) blob[i] = (uint8_t)(i * 31 + (i >> 12));
    FILE *file = fopen(w->blob_path, "wb");
    assert_int_equal(fwrite(blob, 1, BYTES, file), BYTES);
    fclose(file);
    struct peer p = peer_open(w);
    peer_join(&p);
    for (uint64_t at = 0; at < BYTES;) {
        struct frame_view f;
        struct message_blob_part part;
        struct message_blob_get get = {
            .digest = {{1}}, .offset = at, .size_bytes = LIMIT_BLOB_PART_BYTES};
        message_encode_blob_get(&p.w, &get);
        assert_true(peer_send(&p, MESSAGE_BLOB_GET, 5, NULL, 0));
        peer_expect(&p, MESSAGE_BLOB_PART, &f);
        assert_int_equal(f.request_id, 5);
        assert_int_equal(message_decode_blob_part(f.payload, f.payload_bytes, &part), 0);
        assert_int_equal(part.total_bytes, BYTES);
        assert_int_equal(part.offset, at);
        assert_memory_equal(part.bytes, blob + at, part.size_bytes);
        at += part.size_bytes;
    }
    struct frame_view f;
    struct message_blob_get get = {.digest = {{2}}, .size_bytes = 10};
    message_encode_blob_get(&p.w, &get);
    assert_true(peer_send(&p, MESSAGE_BLOB_GET, 6, NULL, 0));
    peer_expect(&p, MESSAGE_BLOB_NONE, &f);
    get = (struct message_blob_get){.digest = {{1}}, .offset = BYTES, .size_bytes = 10};
    message_encode_blob_get(&p.w, &get);
    assert_true(peer_send(&p, MESSAGE_BLOB_GET, 7, NULL, 0));
    peer_expect_close(&p); /* beyond the end */
    peer_close(&p);
    free(blob);
    world_close(w);
}

static void draining_workers_get_nothing(void **state)
{
    (void)state;
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct frame_view f;
    struct message_tile tile;
    uint64_t id = peer_join(&p);
    assert_int_equal(fleet_drain(w->fleet, id + 1, true), ERR_NOT_FOUND);
    assert_int_equal(fleet_drain(w->fleet, id, true), 0);
    assert_int_equal(fleet_drain(w->fleet, id, true), 0);
    peer_expect(&p, MESSAGE_DRAIN, &f);
    w->tiles = 1;
    peer_want(&p, 1);
    peer_expect_nothing(&p);
    assert_int_equal(fleet_drain(w->fleet, id, false), 0);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_tile(&p, &tile);
    peer_close(&p);
    world_close(w);
}

static void refuses_to_listen_where_it_must_not(void **state)
{
    (void)state;
    static const char *const wrong[] = {"0.0.0.0:0",       "192.168.1.1:80", "[::]:0", "127.0.0.1",
                                        "127.0.0.1:99999", "nowhere:7",      ":7"};
    uv_loop_t loop;
    uv_loop_init(&loop);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const struct fleet_options options = {.listen = wrong[i]};
        struct fault fault = {0};
        struct fleet *fleet = NULL;
        assert_true(fleet_create(&loop, &options, &client_of_world, &fleet, &fault) < 0);
        assert_string_equal(fault.pointer, wrong[i]);
        assert_null(fleet);
        uv_run(&loop, UV_RUN_DEFAULT);
    }
    assert_int_equal(uv_loop_close(&loop), 0);
}

static void the_socket_is_private_and_replaces_a_dead_one(void **state)
{
    (void)state;
    struct stat st;
    struct world *w = world_open(LONG_MS, LONG_MS);
    assert_int_equal(stat(w->socket_path, &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
    assert_true(fleet_port(w->fleet) > 0);
    char path[100];
    snprintf(path, sizeof path, "%s", w->socket_path);
    const struct fleet_options options = {.socket_path = path};
    struct fault fault = {0};
    struct fleet *second = NULL;
    assert_int_equal(fleet_create(&w->loop, &options, &client_of_world, &second, &fault),
                     ERR_EXISTS);
    world_close(w);
    assert_int_not_equal(stat(path, &st), 0);
    /* A socket that its owner left behind. */
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    memcpy(a.sun_path, path, strlen(path) + 1);
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&a, sizeof a), 0);
    close(fd);
    world_close(world_open_with(&options));
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tile_goes_out_and_its_result_in),
        cmocka_unit_test(waiting_workers_are_served_on_a_wake),
        cmocka_unit_test(late_verdicts_and_cancelled_frames),
        cmocka_unit_test(mismatches_are_refused_with_advice),
        cmocka_unit_test(an_unknown_hello_is_refused),
        cmocka_unit_test(out_of_state_and_damaged_messages_end_the_session),
        cmocka_unit_test(foreign_and_old_results_do_not_pass_as_leases),
        cmocka_unit_test(given_back_and_faulted_tiles_reach_the_client),
        cmocka_unit_test(silence_ends_a_session),
        cmocka_unit_test(a_late_hello_is_not_awaited),
        cmocka_unit_test(a_stalled_tile_is_taken_back),
        cmocka_unit_test(unacknowledged_results_stop_the_reading),
        cmocka_unit_test(blobs_are_served_in_parts),
        cmocka_unit_test(draining_workers_get_nothing),
        cmocka_unit_test(refuses_to_listen_where_it_must_not),
        cmocka_unit_test(the_socket_is_private_and_replaces_a_dead_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
