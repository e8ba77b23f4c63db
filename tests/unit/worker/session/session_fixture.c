#include "tests/unit/worker/session/session_fixture.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define TRACE "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"

bool told(const struct world *w, const char *what, const char *detail)
{
    char text[16384];
    const ssize_t n = pread(w->worker_log.log.fd, text, sizeof text - 1, 0);
    assert_true(n >= 0);
    text[n] = '\0';
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
        if (strstr(line, what) && strstr(line, detail) && strstr(line, "worker=tester"))
            return true;
    return false;
}

void on_ended(void *ctx, enum session_end end, const char *text)
{
    struct world *w = ctx;
    w->ended = true;
    w->end = end;
    snprintf(w->text, sizeof w->text, "%s", text);
}

void on_closed(void *ctx)
{
    struct world *w = ctx;
    w->closed = true;
}

void turn(struct world *w)
{
    uv_run(&w->loop, UV_RUN_NOWAIT);
    usleep(500);
    uv_update_time(&w->loop);
}

static void listen_there(struct world *w)
{
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    snprintf(a.sun_path, sizeof a.sun_path, "%s/s", w->dir);
    w->listener = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(w->listener, (struct sockaddr *)&a, sizeof a), 0);
    assert_int_equal(listen(w->listener, 5), 0);
}

struct world *world_open(uint32_t threads, bool with_blobs)
{
    return world_open_with(threads, with_blobs, &(const struct options){.threads = 0});
}

struct world *world_open_with(uint32_t threads, bool with_blobs, const struct options *deadlines)
{
    struct world *w = calloc(1, sizeof *w);
    const struct session_client client = {w, &w->worker_log, on_ended, NULL};
    struct fault fault = {0};
    snprintf(w->dir, sizeof w->dir, "/tmp/shearwater-test-session-XXXXXX");
    assert_non_null(mkdtemp(w->dir));
    snprintf(w->address, sizeof w->address, "unix:%s/s", w->dir);
    snprintf(w->cache, sizeof w->cache, "%s/cache", w->dir);
    w->worker_log = (struct worker_log){
        .log = {.fd = open(w->dir, O_TMPFILE | O_RDWR | O_APPEND, 0600)}, .worker = "tester"};
    assert_true(w->worker_log.log.fd >= 0);
    snprintf(w->blobs, sizeof w->blobs, "%s/blobs", w->dir);
    w->options = (struct options){.connect = w->address,
                                  .cache_dir = w->cache,
                                  .blob_dir = with_blobs ? w->blobs : NULL,
                                  .cache_bytes = 100 << 20,
                                  .threads = threads,
                                  .tiles_in_hand = 2 * threads,
                                  .name = "tester",
                                  .connect_within_s = deadlines->connect_within_s,
                                  .idle_exit_s = deadlines->idle_exit_s,
                                  .lifetime_s = deadlines->lifetime_s};
    w->fd = -1;
    w->blob = malloc(BLOB_BYTES);
    for (size_t i = 0; i < BLOB_BYTES; i++) w->blob[i] = (uint8_t)(i * 7 + (i >> 9));
    plan_case(&w->plan);
    digest_of(w->blob, BLOB_BYTES, &w->plan.scene);
    memset(w->map, 5, sizeof w->map);
    memcpy(w->map, ENVIRONMENT_MAGIC, sizeof ENVIRONMENT_MAGIC);
    digest_of(w->map, MAP_BYTES, &w->map_digest);
    w->plan.environment = (struct plan_environment){.kind = ENVIRONMENT_NONE};
    w->plan.paths.spp = 40; /* three passes */
    w->plan.occlusion_distance = 1.0f;
    hold = false;
    tracing = loads = unloads = 0;
    load_steps = 0;
    load_hangs = load_spins = false;
    listen_there(w);
    uv_loop_init(&w->loop);
    wire_frame_inbox_init(&w->inbox, LIMIT_FRAME_BYTES);
    bytes_writer_init(&w->w);
    if (session_create(&w->loop, &w->options, &fake_tracing, &client, &w->session, &fault) != 0)
        fail_msg("%s: %s", fault.pointer, fault.detail);
    session_start(w->session);
    return w;
}

void world_close(struct world *w)
{
    char command[100];
    session_close(w->session, on_closed, w);
    while (!w->closed) uv_run(&w->loop, UV_RUN_ONCE);
    assert_int_equal(uv_loop_close(&w->loop), 0);
    assert_int_equal(loads, unloads);
    if (w->fd >= 0) close(w->fd);
    close(w->worker_log.log.fd);
    close(w->listener);
    wire_frame_inbox_fini(&w->inbox);
    bytes_writer_fini(&w->w);
    snprintf(command, sizeof command, "rm -rf %s", w->dir);
    assert_int_equal(system(command), 0);
    free(w->blob);
    free(w);
}

void accept_link(struct world *w)
{
    wire_frame_inbox_fini(&w->inbox);
    wire_frame_inbox_init(&w->inbox, LIMIT_FRAME_BYTES);
    for (int i = 0; i < 2 * PATIENCE_MS && w->fd < 0; i++) {
        w->fd = accept4(w->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
        turn(w);
    }
    assert_true(w->fd >= 0);
    w->asked = 0;
}

void drop_link(struct world *w)
{
    close(w->fd);
    w->fd = -1;
}

void put(struct world *w, uint16_t type, const void *tail, uint32_t tail_bytes)
{
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    struct bytes_writer whole;
    wire_frame_header(header, type, 1, w->w.data, (uint32_t)w->w.size_bytes, tail, tail_bytes);
    bytes_writer_init(&whole);
    bytes_write_raw(&whole, header, sizeof header);
    bytes_write_raw(&whole, w->w.data, w->w.size_bytes);
    if (tail_bytes > 0) bytes_write_raw(&whole, tail, tail_bytes);
    for (size_t at = 0; at < whole.size_bytes;) {
        ssize_t n = send(w->fd, whole.data + at, whole.size_bytes - at, MSG_NOSIGNAL);
        assert_true(n > 0 || errno == EAGAIN);
        if (n > 0) at += (size_t)n;
        if (n < 0) turn(w);
    }
    bytes_writer_fini(&whole);
    w->w.size_bytes = 0;
}

bool read_some(struct world *w)
{
    size_t space_bytes = 0;
    uint8_t *space = wire_frame_inbox_space(&w->inbox, &space_bytes);
    ssize_t n = recv(w->fd, space, space_bytes, 0);
    if (n == 0 || (n < 0 && errno != EAGAIN)) return false;
    if (n > 0) wire_frame_inbox_filled(&w->inbox, (size_t)n);
    return true;
}

bool next(struct world *w, struct wire_frame_view *f, int patience_ms)
{
    for (int waited = 0; waited < patience_ms; waited++) {
        while (wire_frame_inbox_next(&w->inbox, f) == 0) {
            struct message_want m;
            if (f->type == MESSAGE_WANT &&
                message_decode_want(f->payload, f->payload_bytes, &m) == 0)
                w->asked += m.tiles;
            if (f->type != MESSAGE_WANT && f->type != MESSAGE_BEAT) return true;
        }
        turn(w);
        if (!read_some(w)) return false;
    }
    return false;
}

void expect(struct world *w, uint16_t type, struct wire_frame_view *f)
{
    if (!next(w, f, PATIENCE_MS)) fail_msg("no %s", message_name(type));
    if (f->type != type) fail_msg("%s, expected %s", message_name(f->type), message_name(type));
}

void expect_nothing(struct world *w)
{
    struct wire_frame_view f;
    if (next(w, &f, 40)) fail_msg("%s", message_name(f.type));
}

void welcome(struct world *w, uint64_t worker_id)
{
    struct wire_frame_view f;
    struct message_hello m;
    if (w->fd < 0) accept_link(w);
    expect(w, MESSAGE_HELLO, &f);
    assert_int_equal(message_decode_hello(f.payload, f.payload_bytes, &m), 0);
    assert_int_equal(m.protocol_version, PROTOCOL_VERSION);
    assert_string_equal(m.build_id, build_id());
    assert_string_equal(m.isa, build_isa());
    assert_string_equal(m.embree_version, "3.13.5");
    assert_string_equal(m.name, "tester");
    assert_int_equal(m.threads, w->options.threads);
    message_encode_welcome(&w->w, &(struct message_welcome){worker_id, 40});
    put(w, MESSAGE_WELCOME, NULL, 0);
}

void send_frame(struct world *w, uint64_t id)
{
    struct bytes_writer p;
    bytes_writer_init(&p);
    plan_encode(&p, &w->plan);
    struct message_frame_plan m = {
        .frame_id = id, .job = "job-nine", .plan = p.data, .plan_bytes = (uint32_t)p.size_bytes};
    strcpy(m.trace, TRACE);
    message_encode_frame_plan(&w->w, &m);
    put(w, MESSAGE_FRAME, NULL, 0);
    bytes_writer_fini(&p);
}

void send_pass(struct world *w, uint64_t frame_id, uint32_t index, uint32_t pass)
{
    const int32_t x = (int32_t)(index % 20) * 32;
    const struct message_tile m = {.frame_id = frame_id,
                                   .index = index,
                                   .generation = 1,
                                   .pass = {.number = pass},
                                   .rect = {x, 0, x + 32, 32}};
    message_encode_tile(&w->w, &m);
    put(w, MESSAGE_TILE, NULL, 0);
}

void send_ack(struct world *w, uint64_t frame_id, uint32_t index)
{
    message_encode_ack(&w->w, &(struct message_ack){frame_id, index, 1, VERDICT_ACCEPTED});
    put(w, MESSAGE_ACK, NULL, 0);
}

uint64_t answer(struct world *w, const struct message_blob_get *get)
{
    const bool is_map = digest_equal(&get->digest, &w->map_digest);
    const uint8_t *bytes = is_map ? w->map : w->blob;
    const uint64_t all_bytes = is_map ? MAP_BYTES : BLOB_BYTES, left = all_bytes - get->offset;
    const uint32_t part = left < get->size_bytes ? (uint32_t)left : get->size_bytes;
    const struct message_blob_part m = {
        .digest = get->digest, .total_bytes = all_bytes, .offset = get->offset, .size_bytes = part};
    message_encode_blob_part(&w->w, &m);
    put(w, MESSAGE_BLOB_PART, bytes + get->offset, part);
    return get->offset + part;
}

void expect_get(struct world *w, struct message_blob_get *get)
{
    struct wire_frame_view f;
    expect(w, MESSAGE_BLOB_GET, &f);
    assert_int_equal(message_decode_blob_get(f.payload, f.payload_bytes, get), 0);
}

void serve_blob(struct world *w)
{
    for (uint64_t sent = 0; sent < BLOB_BYTES;) {
        struct message_blob_get get;
        expect_get(w, &get);
        assert_true(digest_equal(&get.digest, &w->plan.scene));
        sent = answer(w, &get);
    }
}

void give_map(struct world *w)
{
    w->plan.environment = (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .map = w->map_digest, .radiance = {1, 1, 1}, .power = 1};
}

uint32_t expect_result(struct world *w)
{
    struct wire_frame_view f;
    struct message_result m;
    expect(w, MESSAGE_RESULT, &f);
    assert_int_equal(message_decode_result(f.payload, f.payload_bytes, &m), 0);
    assert_int_equal(m.samples_bytes, 4);
    assert_int_equal(m.samples[0] | m.samples[1] << 8, (m.index % 20) * 32);
    assert_int_equal(m.counters.value[COUNTER_RAYS_PRIMARY], 1024);
    return m.index;
}

void warm_up(struct world *w)
{
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 0);
    serve_blob(w);
    assert_int_equal(expect_result(w), 0);
    send_ack(w, 9, 0);
}

void start_tile(struct world *w, uint32_t index)
{
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, index);
}

uint32_t expect_fault(struct world *w, int code, const char *part)
{
    struct wire_frame_view f;
    struct message_tile_fault fault;
    expect(w, MESSAGE_FAULT, &f);
    assert_int_equal(message_decode_tile_fault(f.payload, f.payload_bytes, &fault), 0);
    assert_int_equal(fault.code, code);
    if (!strstr(fault.text, part)) fail_msg("\"%s\" lacks \"%s\"", fault.text, part);
    return fault.index;
}
