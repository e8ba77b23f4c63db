/* The worker's side of the protocol against a scripted coordinator on a real Unix socket, with
 * tracing that costs nothing and waits when it is told to. */
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
#include "proto/count_map.h"
#include "proto/environment.h"
#include "proto/message.h"
#include "tests/unit/proto/plan_case.h"
#include "worker/link.h"
#include "worker/session.h"

#define PATIENCE_MS 5000
#define TRACE       "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"
#define BLOB_BYTES  (LIMIT_BLOB_PART_BYTES + 5000u)
#define MAP_BYTES   3000u
#define LIFE        (5ull << WORKER_ID_LIFE_SHIFT)

/* ---- tracing without rays ---- */

static _Atomic bool hold;        /* tiles wait, and end when they are stopped */
static _Atomic unsigned tracing; /* tiles that a thread has begun */
static _Atomic unsigned loads, unloads;
static _Atomic uint32_t traced_pass;
static _Atomic uint32_t traced_sides; /* their sum; 0: the last tile had none */
static _Atomic uint32_t traced_lobes;
static _Atomic uint32_t load_steps; /* that the next load makes, one each LOAD_STEP_MS */
static _Atomic bool load_hangs;     /* until it is set to false */
static _Atomic bool load_spins;     /* meanwhile it uses a CPU */
#define LOAD_STEP_MS 20
static _Atomic bool traced_map; /* the last tile had an environment */

static const char *embree_version(void *ctx)
{
    (void)ctx;
    return "3.13.5";
}

/* What is loaded is its kind; a map is told by its first bytes. */
static int load(void *ctx, const char *path, unsigned threads, _Atomic uint64_t *steps,
                void **loaded, enum tracing_kind *kind, uint64_t *bytes, uint64_t *cpu_us,
                struct fault *fault)
{
    (void)ctx;
    (void)threads;
    for (uint32_t i = 0; i < load_steps || load_hangs; i++) {
        if (!load_spins) usleep(1000 * LOAD_STEP_MS);
        if (!load_hangs) (*steps)++;
    }
    struct stat st;
    char magic[8] = "";
    if (stat(path, &st) != 0) return fault_set(fault, ERR_IO, path, "is not there");
    FILE *file = fopen(path, "rb");
    if (!file || fread(magic, 1, sizeof magic, file) != sizeof magic) abort();
    fclose(file);
    *kind = memcmp(magic, ENVIRONMENT_MAGIC, 8) == 0 ? TRACING_ENVIRONMENT : TRACING_SCENE;
    *loaded = malloc(sizeof *kind);
    memcpy(*loaded, kind, sizeof *kind);
    *bytes = (uint64_t)st.st_size;
    *cpu_us = 1000;
    loads++;
    return 0;
}

static void unload(void *ctx, void **scene)
{
    (void)ctx;
    free(*scene);
    *scene = NULL;
    unloads++;
}

static int tracer_create(void *ctx, void **tracer)
{
    (void)ctx;
    *tracer = malloc(1);
    return 0;
}

static void tracer_destroy(void *ctx, void **tracer)
{
    (void)ctx;
    free(*tracer);
    *tracer = NULL;
}

static int trace(void *ctx, void *tracer, const void *scene, const void *environment,
                 const struct plan *plan, const struct plan_pass *pass, struct rect rect,
                 _Atomic uint64_t *progress, const _Atomic bool *stop, struct bytes_writer *packed,
                 struct counters *counters)
{
    (void)ctx;
    assert_true(tracer && scene && plan->width_px == 720);
    assert_int_equal(*(const enum tracing_kind *)scene, TRACING_SCENE);
    assert_int_equal(environment != NULL, plan->environment.kind == ENVIRONMENT_MAP);
    if (environment) assert_int_equal(*(const enum tracing_kind *)environment, TRACING_ENVIRONMENT);
    traced_pass = pass->number;
    uint32_t sides = 0;
    for (int64_t i = 0; pass->sides && i < rect_area(rect); i++) sides += pass->sides[i];
    traced_sides = sides;
    sides = 0;
    for (int64_t i = 0; pass->lobes && i < rect_area(rect); i++) sides += pass->lobes[i];
    traced_lobes = sides;
    traced_map = environment != NULL;
    tracing++;
    while (hold && !*stop) usleep(1000);
    *progress += (uint64_t)rect_height(rect);
    counters->value[COUNTER_RAYS_PRIMARY] = (uint64_t)rect_area(rect);
    bytes_write_u32(packed, (uint32_t)rect.x0);
    return *stop ? ERR_STATE : 0;
}

static const struct tracing fake_tracing = {.capabilities = CAPABILITY_DIRECT,
                                            .embree_version = embree_version,
                                            .load = load,
                                            .unload = unload,
                                            .tracer_create = tracer_create,
                                            .tracer_destroy = tracer_destroy,
                                            .trace = trace};

/* ---- a worker and its coordinator ---- */

struct world {
    uv_loop_t loop;
    char dir[64], address[100], cache[100], blobs[100];
    struct options options;
    struct session *session;
    bool ended, closed;
    enum session_end end;
    char text[LIMIT_DETAIL_BYTES];
    struct journal journal; /* to a file in dir */
    int listener, fd;
    struct frame_inbox inbox;
    struct bytes_writer w;
    struct plan plan;
    uint8_t *blob;
    uint8_t map[MAP_BYTES]; /* of an environment */
    struct digest map_digest;
    uint32_t asked; /* tiles that the worker wants, as far as we read */
};

/* Does the worker's log have a line with all of that? */
static bool told(const struct world *w, const char *what, const char *detail)
{
    char text[16384];
    const ssize_t n = pread(w->journal.log.fd, text, sizeof text - 1, 0);
    assert_true(n >= 0);
    text[n] = '\0';
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
        if (strstr(line, what) && strstr(line, detail) && strstr(line, "worker=tester"))
            return true;
    return false;
}

static void on_ended(void *ctx, enum session_end end, const char *text)
{
    struct world *w = ctx;
    w->ended = true;
    w->end = end;
    snprintf(w->text, sizeof w->text, "%s", text);
}

static void on_closed(void *ctx)
{
    struct world *w = ctx;
    w->closed = true;
}

static void turn(struct world *w)
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

static struct world *world_open(uint32_t threads, bool with_blobs)
{
    struct world *w = calloc(1, sizeof *w);
    const struct session_client client = {w, &w->journal, on_ended, NULL};
    struct fault fault = {0};
    snprintf(w->dir, sizeof w->dir, "/tmp/shearwater-test-session-XXXXXX");
    assert_non_null(mkdtemp(w->dir));
    snprintf(w->address, sizeof w->address, "unix:%s/s", w->dir);
    snprintf(w->cache, sizeof w->cache, "%s/cache", w->dir);
    w->journal = (struct journal){.log = {.fd = open(w->dir, O_TMPFILE | O_RDWR | O_APPEND, 0600)},
                                  .worker = "tester"};
    assert_true(w->journal.log.fd >= 0);
    snprintf(w->blobs, sizeof w->blobs, "%s/blobs", w->dir);
    w->options = (struct options){.connect = w->address,
                                  .cache_dir = w->cache,
                                  .blob_dir = with_blobs ? w->blobs : NULL,
                                  .cache_bytes = 100 << 20,
                                  .threads = threads,
                                  .tiles_in_hand = 2 * threads,
                                  .name = "tester"};
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
    frame_inbox_init(&w->inbox, LIMIT_FRAME_BYTES);
    bytes_writer_init(&w->w);
    if (session_create(&w->loop, &w->options, &fake_tracing, &client, &w->session, &fault) != 0)
        fail_msg("%s: %s", fault.pointer, fault.detail);
    session_start(w->session);
    return w;
}

static void world_close(struct world *w)
{
    char command[100];
    session_close(w->session, on_closed, w);
    while (!w->closed) uv_run(&w->loop, UV_RUN_ONCE);
    assert_int_equal(uv_loop_close(&w->loop), 0);
    assert_int_equal(loads, unloads);
    if (w->fd >= 0) close(w->fd);
    close(w->journal.log.fd);
    close(w->listener);
    frame_inbox_fini(&w->inbox);
    bytes_writer_fini(&w->w);
    snprintf(command, sizeof command, "rm -rf %s", w->dir);
    assert_int_equal(system(command), 0);
    free(w->blob);
    free(w);
}

static void accept_link(struct world *w)
{
    frame_inbox_fini(&w->inbox);
    frame_inbox_init(&w->inbox, LIMIT_FRAME_BYTES);
    for (int i = 0; i < 2 * PATIENCE_MS && w->fd < 0; i++) {
        w->fd = accept4(w->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
        turn(w);
    }
    assert_true(w->fd >= 0);
    w->asked = 0;
}

static void drop_link(struct world *w)
{
    close(w->fd);
    w->fd = -1;
}

static void put(struct world *w, uint16_t type, const void *tail, uint32_t tail_bytes)
{
    uint8_t header[FRAME_HEADER_BYTES];
    struct bytes_writer whole;
    frame_header(header, type, 1, w->w.data, (uint32_t)w->w.size_bytes, tail, tail_bytes);
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

static bool read_some(struct world *w)
{
    size_t space_bytes = 0;
    uint8_t *space = frame_inbox_space(&w->inbox, &space_bytes);
    ssize_t n = recv(w->fd, space, space_bytes, 0);
    if (n == 0 || (n < 0 && errno != EAGAIN)) return false;
    if (n > 0) frame_inbox_filled(&w->inbox, (size_t)n);
    return true;
}

/* The next frame but beats and wants. False: the worker closed the link, or nothing came. */
static bool next(struct world *w, struct frame_view *f, int patience_ms)
{
    for (int waited = 0; waited < patience_ms; waited++) {
        while (frame_inbox_next(&w->inbox, f) == 0) {
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

static void expect(struct world *w, uint16_t type, struct frame_view *f)
{
    if (!next(w, f, PATIENCE_MS)) fail_msg("no %s", message_name(type));
    if (f->type != type) fail_msg("%s, expected %s", message_name(f->type), message_name(type));
}

static void expect_nothing(struct world *w)
{
    struct frame_view f;
    if (next(w, &f, 40)) fail_msg("%s", message_name(f.type));
}

static void welcome(struct world *w, uint64_t worker_id)
{
    struct frame_view f;
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

static void send_frame(struct world *w, uint64_t id)
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

static void send_pass(struct world *w, uint64_t frame_id, uint32_t index, uint32_t pass)
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

static void send_tile(struct world *w, uint64_t frame_id, uint32_t index)
{
    send_pass(w, frame_id, index, 0);
}

static void send_ack(struct world *w, uint64_t frame_id, uint32_t index)
{
    message_encode_ack(&w->w, &(struct message_ack){frame_id, index, 1, VERDICT_ACCEPTED});
    put(w, MESSAGE_ACK, NULL, 0);
}

/* Answers a question for a part of the scene or the map. Returns the offset behind the part. */
static uint64_t answer(struct world *w, const struct message_blob_get *get)
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

static void expect_get(struct world *w, struct message_blob_get *get)
{
    struct frame_view f;
    expect(w, MESSAGE_BLOB_GET, &f);
    assert_int_equal(message_decode_blob_get(f.payload, f.payload_bytes, get), 0);
}

static void serve_blob(struct world *w)
{
    for (uint64_t sent = 0; sent < BLOB_BYTES;) {
        struct message_blob_get get;
        expect_get(w, &get);
        assert_true(digest_equal(&get.digest, &w->plan.scene));
        sent = answer(w, &get);
    }
}

/* The first questions for a scene and for a map, in whatever order they come. */
static void expect_both(struct world *w, struct message_blob_get *scene,
                        struct message_blob_get *map)
{
    struct message_blob_get first, second;
    expect_get(w, &first);
    expect_get(w, &second);
    const bool scene_first = digest_equal(&first.digest, &w->plan.scene);
    *scene = scene_first ? first : second;
    *map = scene_first ? second : first;
    assert_true(digest_equal(&scene->digest, &w->plan.scene));
    assert_true(digest_equal(&map->digest, &w->plan.environment.map));
}

static void give_map(struct world *w)
{
    w->plan.environment = (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .map = w->map_digest, .radiance = {1, 1, 1}, .power = 1};
}

static uint32_t expect_result(struct world *w)
{
    struct frame_view f;
    struct message_result m;
    expect(w, MESSAGE_RESULT, &f);
    assert_int_equal(message_decode_result(f.payload, f.payload_bytes, &m), 0);
    assert_int_equal(m.samples_bytes, 4);
    assert_int_equal(m.samples[0] | m.samples[1] << 8, (m.index % 20) * 32);
    assert_int_equal(m.counters.value[COUNTER_RAYS_PRIMARY], 1024);
    return m.index;
}

/* A scene in hand and tile 0 answered. */
static void warm_up(struct world *w)
{
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 0);
    serve_blob(w);
    assert_int_equal(expect_result(w), 0);
    send_ack(w, 9, 0);
}

/* ---- tests ---- */

static void a_tile_is_fetched_for_traced_and_answered(void **state)
{
    (void)state;
    struct world *w = world_open(2, false);
    welcome(w, LIFE | 1);
    for (int i = 0; w->asked == 0 && i < PATIENCE_MS; i++) expect_nothing(w);
    assert_int_equal(w->asked, 4);
    send_frame(w, 9);
    send_tile(w, 9, 3);
    send_tile(w, 9, 4);
    serve_blob(w);
    assert_int_equal(expect_result(w) + expect_result(w), 7);
    send_ack(w, 9, 3);
    send_ack(w, 9, 4);
    expect_nothing(w);
    assert_int_equal(w->asked, 6);
    assert_int_equal(loads, 1);
    send_frame(w, 10); /* the scene is still there */
    send_tile(w, 10, 5);
    assert_int_equal(expect_result(w), 5);
    assert_int_equal(loads, 1);
    world_close(w);
}

static void local_blobs_are_mapped_where_they_lie(void **state)
{
    (void)state;
    struct world *w = world_open(1, true);
    char path[300], hex[DIGEST_HEX_BYTES];
    digest_to_hex(&w->plan.scene, hex);
    mkdir(w->blobs, 0700);
    snprintf(path, sizeof path, "%s/%.2s", w->blobs, hex);
    mkdir(path, 0700);
    snprintf(path, sizeof path, "%s/%.2s/%s", w->blobs, hex, hex + 2);
    FILE *file = fopen(path, "wb");
    fwrite(w->blob, 1, BLOB_BYTES, file);
    fclose(file);
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 3);
    assert_int_equal(expect_result(w), 3); /* and no BLOB_GET */
    assert_int_not_equal(access(w->cache, F_OK), 0);
    world_close(w);
}

static void a_cached_blob_is_not_fetched_again(void **state)
{
    (void)state;
    struct world *w = world_open(1, true); /* of blobs there is only an empty folder */
    warm_up(w);
    drop_link(w);
    struct session *old = w->session;
    struct fault fault = {0};
    const struct session_client client = {w, &w->journal, on_ended, NULL};
    session_close(old, on_closed, w);
    while (!w->closed) uv_run(&w->loop, UV_RUN_ONCE);
    w->closed = false;
    assert_int_equal(
        session_create(&w->loop, &w->options, &fake_tracing, &client, &w->session, &fault), 0);
    session_start(w->session);
    welcome(w, LIFE | 2);
    send_frame(w, 9);
    send_tile(w, 9, 3);
    assert_int_equal(expect_result(w), 3);
    world_close(w);
}

static void results_are_kept_until_acknowledged(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    warm_up(w);
    send_tile(w, 9, 1);
    send_tile(w, 9, 2);
    assert_int_equal(expect_result(w), 1);
    assert_int_equal(expect_result(w), 2);
    send_ack(w, 9, 1);
    expect_nothing(w);
    drop_link(w);
    welcome(w, LIFE | 2); /* the same coordinator: the rest is said again */
    assert_int_equal(expect_result(w), 2);
    assert_int_equal(w->journal.log.lines[LOG_INFO], 3); /* connected, a job's frame, connected */
    assert_int_equal(w->journal.log.lines[LOG_WARNING], 1);
    assert_true(told(w, "warning link lost", "trying again"));
    drop_link(w);
    welcome(w, (LIFE + (1ull << WORKER_ID_LIFE_SHIFT)) | 1); /* another one */
    expect_nothing(w);
    world_close(w);
}

static void a_refusal_ends_the_worker(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    accept_link(w);
    expect(w, MESSAGE_HELLO, &f);
    message_encode_refused(&w->w, &(struct message_refused){ERR_MISMATCH, "install the same"});
    put(w, MESSAGE_REFUSED, NULL, 0);
    for (int i = 0; !w->ended && i < PATIENCE_MS; i++) turn(w);
    assert_int_equal(w->end, SESSION_END_REFUSED);
    assert_string_equal(w->text, "install the same");
    world_close(w);
}

static void illegal_messages_break_the_link(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    for (int i = 0; i < 6; i++) {
        welcome(w, LIFE | 1);
        switch (i) {
        case 0: /* no such frame */
            send_tile(w, 1234, 0);
            break;
        case 1:
            message_encode_welcome(&w->w, &(struct message_welcome){LIFE | 1, 40});
            put(w, MESSAGE_WELCOME, NULL, 0);
            break;
        case 2:
            message_encode_want(&w->w, &(struct message_want){1});
            put(w, MESSAGE_WANT, NULL, 0);
            break;
        case 3: /* outside the frame */
            send_frame(w, 9);
            message_encode_tile(
                &w->w,
                &(struct message_tile){.frame_id = 9, .generation = 1, .rect = {704, 0, 736, 32}});
            put(w, MESSAGE_TILE, NULL, 0);
            break;
        case 4: /* a pass too many */
            send_frame(w, 9);
            send_pass(w, 9, 0, 3);
            break;
        default:
            assert_int_equal(send(w->fd, "no frame at all, but long enough", 32, 0), 32);
        }
        while (next(w, &f, PATIENCE_MS)) {
        }
        drop_link(w);
    }
    assert_false(w->ended);
    world_close(w);
}

static void a_missing_blob_is_a_fault_of_its_tiles(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    struct message_tile_fault fault;
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    expect(w, MESSAGE_BLOB_GET, &f);
    message_encode_blob_none(&w->w, &(struct message_blob_none){w->plan.scene});
    put(w, MESSAGE_BLOB_NONE, NULL, 0);
    expect(w, MESSAGE_FAULT, &f);
    assert_int_equal(message_decode_tile_fault(f.payload, f.payload_bytes, &fault), 0);
    assert_int_equal(fault.code, ERR_NOT_FOUND);
    assert_int_equal(fault.index, 1);
    assert_true(told(w, "info work for a job", "trace=4bf92f3577b34da6a3ce929d0e0e4736"));
    assert_true(told(w, "warning tile cannot be traced", "job=job-nine frame_id=9 tile=1"));
    assert_true(told(w, "tile cannot be traced", "request=00f067aa0ba902b7"));
    send_tile(w, 9, 2); /* it tries again */
    serve_blob(w);
    assert_int_equal(expect_result(w), 2);
    world_close(w);
}

static void a_fetch_goes_on_after_a_reconnect(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    struct message_blob_get get;
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    expect(w, MESSAGE_BLOB_GET, &f);
    const struct message_blob_part m = {
        .digest = w->plan.scene, .total_bytes = BLOB_BYTES, .size_bytes = LIMIT_BLOB_PART_BYTES};
    message_encode_blob_part(&w->w, &m);
    put(w, MESSAGE_BLOB_PART, w->blob, LIMIT_BLOB_PART_BYTES);
    expect(w, MESSAGE_BLOB_GET, &f);
    drop_link(w);
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    expect(w, MESSAGE_BLOB_GET, &f);
    assert_int_equal(message_decode_blob_get(f.payload, f.payload_bytes, &get), 0);
    assert_int_equal(get.offset, LIMIT_BLOB_PART_BYTES - 1);
    const struct message_blob_part rest = {.digest = w->plan.scene,
                                           .total_bytes = BLOB_BYTES,
                                           .offset = get.offset,
                                           .size_bytes = BLOB_BYTES - (uint32_t)get.offset};
    message_encode_blob_part(&w->w, &rest);
    put(w, MESSAGE_BLOB_PART, w->blob + get.offset, rest.size_bytes);
    assert_int_equal(expect_result(w), 1);
    world_close(w);
}

static void damaged_blobs_are_not_traced(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    w->blob[100] ^= 1;
    serve_blob(w);
    serve_blob(w); /* a second try, from the start */
    expect(w, MESSAGE_FAULT, &f);
    struct message_tile_fault fault;
    assert_int_equal(message_decode_tile_fault(f.payload, f.payload_bytes, &fault), 0);
    assert_int_equal(fault.code, ERR_CHECKSUM);
    assert_int_equal(loads, 0);
    world_close(w);
}

static void a_map_is_fetched_beside_the_scene(void **state)
{
    (void)state;
    struct world *w = world_open(2, false);
    struct message_blob_get scene, map;
    give_map(w);
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 3);
    expect_both(w, &scene, &map);
    assert_int_equal(answer(w, &map), MAP_BYTES);
    for (int i = 0; loads == 0 && i < PATIENCE_MS; i++) turn(w);
    expect_nothing(w); /* the scene is not there yet */
    assert_int_equal(tracing, 0);
    answer(w, &scene);
    serve_blob(w);
    assert_int_equal(expect_result(w), 3);
    assert_true(traced_map);
    assert_int_equal(loads, 2);
    send_ack(w, 9, 3);
    w->plan.environment.kind = ENVIRONMENT_NONE;
    send_frame(w, 10);
    send_tile(w, 10, 4);
    assert_int_equal(expect_result(w), 4); /* the same scene without */
    assert_false(traced_map);
    send_ack(w, 10, 4);
    w->plan.environment.kind = ENVIRONMENT_MAP;
    send_frame(w, 11);
    send_tile(w, 11, 5);
    assert_int_equal(expect_result(w), 5); /* both are still there */
    assert_int_equal(loads, 2);
    world_close(w);
}

static void expect_fault(struct world *w, int code, const char *part)
{
    struct frame_view f;
    struct message_tile_fault fault;
    expect(w, MESSAGE_FAULT, &f);
    assert_int_equal(message_decode_tile_fault(f.payload, f.payload_bytes, &fault), 0);
    assert_int_equal(fault.code, code);
    if (!strstr(fault.text, part)) fail_msg("\"%s\" lacks \"%s\"", fault.text, part);
}

static void a_missing_map_is_named(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct message_blob_get scene, map;
    give_map(w);
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    expect_both(w, &scene, &map);
    message_encode_blob_none(&w->w, &(struct message_blob_none){w->map_digest});
    put(w, MESSAGE_BLOB_NONE, NULL, 0);
    expect_fault(w, ERR_NOT_FOUND, "environment: the coordinator does not have the blob");
    answer(w, &scene); /* nobody waits for it any longer */
    expect_nothing(w);
    send_tile(w, 9, 2); /* it tries again */
    expect_both(w, &scene, &map);
    answer(w, &scene);
    answer(w, &map);
    serve_blob(w);
    assert_int_equal(expect_result(w), 2);
    send_ack(w, 9, 2);
    expect_nothing(w);
    world_close(w);
}

static void a_missing_scene_beside_a_map_is_named(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct message_blob_get scene, map;
    give_map(w);
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    expect_both(w, &scene, &map);
    answer(w, &map);
    for (int i = 0; loads == 0 && i < PATIENCE_MS; i++) turn(w);
    message_encode_blob_none(&w->w, &(struct message_blob_none){w->plan.scene});
    put(w, MESSAGE_BLOB_NONE, NULL, 0);
    expect_fault(w, ERR_NOT_FOUND, "scene: the coordinator does not have the blob");
    world_close(w);
}

static void blobs_of_the_wrong_kind_are_faults(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct message_blob_get get;
    const struct digest scene = w->plan.scene;
    welcome(w, LIFE | 1);
    w->plan.scene = w->map_digest;
    send_frame(w, 9);
    send_tile(w, 9, 1);
    expect_get(w, &get);
    answer(w, &get);
    expect_fault(w, ERR_MAGIC, "scene: this is an environment map");
    w->plan.scene = scene;
    give_map(w);
    w->plan.environment.map = scene; /* the same blob twice */
    send_frame(w, 10);
    send_tile(w, 10, 1);
    serve_blob(w);
    expect_fault(w, ERR_MAGIC, "environment: this is a scene");
    send_tile(w, 10, 2); /* it is loaded by now */
    expect_fault(w, ERR_MAGIC, "environment: this is a scene");
    assert_int_equal(tracing, 0);
    world_close(w);
}

static void a_cancelled_frame_lets_both_blobs_go(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct message_blob_get scene, map;
    give_map(w);
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    expect_both(w, &scene, &map);
    message_encode_cancel(&w->w, &(struct message_cancel){9});
    put(w, MESSAGE_CANCEL, NULL, 0);
    expect_nothing(w);
    answer(w, &map);
    answer(w, &scene);
    expect_nothing(w);
    assert_int_equal(loads, 0);
    world_close(w);
}

static void a_lease_names_its_pass(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    warm_up(w);
    for (uint32_t pass = 3; pass-- > 0;) {
        send_pass(w, 9, 1, pass);
        assert_int_equal(expect_result(w), 1);
        assert_int_equal(traced_pass, pass);
        send_ack(w, 9, 1);
    }
    world_close(w);
}

/* A second set for a tile of 32 x 32, `damage` of its bytes spoilt. */
static void send_sides(struct world *w, uint64_t frame_id, uint32_t index, uint32_t strata,
                       uint8_t side, size_t damage)
{
    const int32_t x = (int32_t)(index % 20) * 32;
    const uint32_t maps = plan_side_maps(&w->plan) > 1 ? 2 : 1;
    uint8_t sides[2 * 32 * 32] = {0};
    struct bytes_writer packed;
    bytes_writer_init(&packed);
    for (int i = 0; i < 32; i++) sides[i * 32] = side;
    if (maps > 1) sides[2 * 32 * 32 - 1] = 1;
    assert_int_equal(count_map_pack(&packed, sides, maps, 32, 32), 0);
    memset(packed.data, 0xa5, damage);
    const struct message_tile m = {
        .frame_id = frame_id,
        .index = index,
        .generation = 1,
        .pass = {.number = plan_pass_count(&w->plan), .strata = strata},
        .rect = {x, 0, x + 32, 32},
        .counts = packed.data,
        .counts_bytes = (uint32_t)packed.size_bytes,
    };
    message_encode_tile(&w->w, &m);
    put(w, MESSAGE_TILE, NULL, 0);
    bytes_writer_fini(&packed);
}

static void rate_plan(struct world *w)
{
    w->plan.indirect_filter = INDIRECT_FILTER_RATE;
    w->plan.rate = (struct plan_rate){.mu = 1, .rays_most = 100};
    w->plan.planes &=
        ~(PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF));
}

static void a_lease_has_its_pixels_sides(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    rate_plan(w);
    warm_up(w);
    send_sides(w, 9, 1, 7, 7, 0);
    assert_int_equal(expect_result(w), 1);
    assert_int_equal(traced_sides, 7 * 32);
    send_ack(w, 9, 1);
    send_pass(w, 9, 2, 1);
    assert_int_equal(expect_result(w), 2);
    assert_int_equal(traced_sides, 0);
    world_close(w);
}

/* And those of its glossy lobes, where the plan has them. */
static void a_lease_has_its_lobes_sides(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    rate_plan(w);
    w->plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_SPAN);
    warm_up(w);
    send_sides(w, 9, 1, 7, 7, 0);
    assert_int_equal(expect_result(w), 1);
    assert_true(traced_sides == 7 * 32 && traced_lobes == 1);
    world_close(w);
}

/* Sides that are none, too many, none of the plan's, or for a plan without. */
static void sides_that_do_not_fit_break_the_link(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    const struct plan plain = w->plan;
    for (int i = 0; i < 6; i++) {
        w->plan = plain;
        if (i < 5) rate_plan(w);
        welcome(w, LIFE | 1);
        send_frame(w, 9);
        switch (i) {
        case 0:
            send_sides(w, 9, 1, 7, 7, 12);
            break;
        case 1: /* the largest is not what the lease says */
            send_sides(w, 9, 1, 8, 7, 0);
            break;
        case 2: /* more rays than the plan has: 9 and 100 */
            send_sides(w, 9, 1, 10, 10, 0);
            break;
        case 3: /* no pixel gets any */
            send_sides(w, 9, 1, 0, 0, 0);
            break;
        case 4: /* the pass without its sides */
            send_pass(w, 9, 1, plan_pass_count(&w->plan));
            break;
        default:
            send_sides(w, 9, 1, 7, 7, 0);
        }
        while (next(w, &f, PATIENCE_MS)) {
        }
        drop_link(w);
    }
    assert_false(w->ended);
    world_close(w);
}

static void a_cancelled_frame_is_stopped(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    send_tile(w, 9, 2);
    while (tracing < 2) turn(w); /* the first was tile 0 */
    message_encode_cancel(&w->w, &(struct message_cancel){9});
    put(w, MESSAGE_CANCEL, NULL, 0);
    expect_nothing(w);
    hold = false;
    expect_nothing(w);
    assert_int_equal(w->asked, 5); /* 2, and 3 for those that are through */
    send_frame(w, 10);
    send_tile(w, 10, 3);
    assert_int_equal(expect_result(w), 3);
    world_close(w);
}

static void told_to_stop_it_finishes_what_it_traces(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    struct message_returned back;
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    send_tile(w, 9, 2);
    while (tracing < 2) turn(w);
    session_stop(w->session);
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 2);
    send_tile(w, 9, 5); /* it crosses: back at once */
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 5);
    hold = false;
    assert_int_equal(expect_result(w), 1);
    assert_false(w->ended);
    send_ack(w, 9, 1);
    expect(w, MESSAGE_BYE, &f);
    assert_true(w->ended);
    assert_int_equal(w->end, SESSION_END_TOLD);
    world_close(w);
}

static void told_twice_it_leaves_at_once(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    warm_up(w);
    hold = true;
    send_tile(w, 9, 1);
    while (tracing < 2) turn(w);
    session_stop(w->session);
    expect_nothing(w);
    session_stop(w->session);
    expect(w, MESSAGE_RETURN, &f);
    expect(w, MESSAGE_BYE, &f);
    assert_int_equal(w->end, SESSION_END_TOLD);
    world_close(w);
}

static void a_drained_worker_asks_again_after_a_tile(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    warm_up(w);
    expect_nothing(w);
    uint32_t asked = w->asked;
    message_encode_drain(&w->w, &(struct message_drain){0});
    put(w, MESSAGE_DRAIN, NULL, 0);
    expect_nothing(w);
    assert_int_equal(session_state(w->session), SESSION_DRAINING);
    assert_int_equal(w->asked, asked);
    send_tile(w, 9, 1);
    assert_int_equal(expect_result(w), 1);
    expect_nothing(w);
    assert_int_equal(session_state(w->session), SESSION_WORKING);
    assert_true(w->asked > asked);
    world_close(w);
}

static void with_its_parent_it_ends(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    w->options.exit_with_parent = true;
    welcome(w, LIFE | 1);
    expect_nothing(w);
    drop_link(w);
    for (int i = 0; !w->ended && i < PATIENCE_MS; i++) turn(w);
    assert_int_equal(w->end, SESSION_END_FAILED);
    world_close(w);
}

static void beats_tell_of_progress(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct frame_view f;
    struct message_beat m = {0};
    warm_up(w);
    for (int i = 0; i < PATIENCE_MS && m.progress < 34; i++) {
        turn(w);
        read_some(w);
        while (frame_inbox_next(&w->inbox, &f) == 0)
            if (f.type == MESSAGE_BEAT)
                assert_int_equal(message_decode_beat(f.payload, f.payload_bytes, &m), 0);
    }
    assert_true(m.progress >= 34); /* 32 rows and two parts */
    assert_true(m.rss_bytes > 0 && m.peak_rss_bytes > 0 && m.cpu_us > 0);
    assert_int_equal(m.phase, BEAT_IDLE);
    world_close(w);
}

static void expect_end_of_load(struct world *w, const char *part)
{
    struct frame_view f;
    struct message_returned back;
    for (int i = 0; !w->ended && i < 2 * PATIENCE_MS; i++) turn(w);
    assert_true(w->ended);
    assert_int_equal(w->end, SESSION_END_FAILED);
    if (!strstr(w->text, part)) fail_msg("\"%s\" lacks \"%s\"", w->text, part);
    expect(w, MESSAGE_RETURN, &f);
    assert_int_equal(message_decode_returned(f.payload, f.payload_bytes, &back), 0);
    assert_int_equal(back.index, 1);
    expect(w, MESSAGE_BYE, &f);
}

static void a_load_that_makes_no_step_ends_the_worker(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    w->options.loading_ms = 200;
    load_hangs = true;
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    serve_blob(w);
    expect_end_of_load(w, "a load has made no step for 1 s");
    load_hangs = false;
    world_close(w);
}

static void one_that_spins_ends_it_sooner(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    w->options.loading_ms = 500;
    load_hangs = load_spins = true;
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    serve_blob(w);
    expect_end_of_load(w, "a load has made no step for 0 s");
    load_hangs = false;
    world_close(w);
}

static void a_long_load_that_makes_steps_does_not(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    w->options.loading_ms = 100;
    load_steps = 1500 / LOAD_STEP_MS;
    welcome(w, LIFE | 1);
    send_frame(w, 9);
    send_tile(w, 9, 1);
    serve_blob(w);
    assert_int_equal(expect_result(w), 1);
    assert_false(w->ended);
    world_close(w);
}

static void nor_does_one_that_waits_for_a_thread(void **state)
{
    (void)state;
    struct world *w = world_open(1, false);
    struct message_blob_get get;
    w->options.loading_ms = 100;
    warm_up(w);
    const uint32_t traced = tracing;
    hold = true;
    send_tile(w, 9, 1); /* takes the one thread */
    for (int i = 0; tracing == traced && i < PATIENCE_MS; i++) turn(w);
    give_map(w);
    send_frame(w, 10);
    send_tile(w, 10, 2);
    for (int i = 0; !w->ended && i < PATIENCE_MS / 2; i++) turn(w);
    assert_false(w->ended);
    hold = false;
    assert_int_equal(expect_result(w), 1);
    expect_get(w, &get);
    answer(w, &get);
    assert_int_equal(expect_result(w), 2);
    world_close(w);
}

static const char *no_version(void *ctx)
{
    (void)ctx;
    return NULL;
}

static void without_embree_there_is_no_worker(void **state)
{
    (void)state;
    uv_loop_t loop;
    struct session *session = NULL;
    struct fault fault = {0};
    const struct options options = {.connect = "unix:/nowhere", .threads = 1, .cache_dir = "/tmp"};
    const struct session_client client = {0};
    const struct tracing broken = {.embree_version = no_version};
    uv_loop_init(&loop);
    assert_int_equal(session_create(&loop, &options, &broken, &client, &session, &fault),
                     ERR_MEMORY);
    assert_string_equal(fault.pointer, "embree");
    assert_null(session);
    assert_int_equal(uv_loop_close(&loop), 0);
}

static void waits_double_up_to_five_seconds(void **state)
{
    (void)state;
    static const uint32_t waits[] = {100, 200, 400, 800, 1600, 3200, 5000, 5000};
    for (unsigned i = 0; i < sizeof waits / sizeof waits[0]; i++)
        assert_int_equal(link_wait_ms(i), waits[i]);
    assert_int_equal(link_wait_ms(UINT32_MAX), 5000);
}

static void addresses_are_checked(void **state)
{
    (void)state;
    static const char *const wrong[] = {"unix:",  "host",       "host:", ":7",
                                        "host:0", "host:70000", "a:b:7", "host:7x"};
    uv_loop_t loop;
    uv_loop_init(&loop);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const struct link_client client = {0};
        struct link *link = NULL;
        struct fault fault = {0};
        assert_true(link_create(&loop, wrong[i], NULL, &client, &link, &fault) < 0);
        assert_string_equal(fault.pointer, wrong[i]);
    }
    assert_int_equal(uv_loop_close(&loop), 0);
}

static void options_are_checked(void **state)
{
    (void)state;
    struct options o;
    struct fault fault = {0};
    char *good[] = {"worker", "--connect", "unix:/x", "--threads", "3", "--cache-bytes", "2G"};
    assert_int_equal(options_read(7, good, &o, &fault), 0);
    assert_int_equal(o.threads, 3);
    assert_int_equal(o.tiles_in_hand, 6);
    assert_int_equal(o.cache_bytes, 2ull << 30);
    static char *const wrong[][2] = {{"--threads", "0"},      {"--threads", "1025"},
                                     {"--threads", "2x"},     {"--threads", "-1"},
                                     {"--cache-bytes", "1T"}, {"--tiles-in-hand", "257"},
                                     {"--name", NULL},        {"--nonsense", "1"},
                                     {"--log-format", "xml"}, {"--cache-bytes", "99999999999G"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        char *argv[] = {"worker", "--connect", "unix:/x", wrong[i][0], wrong[i][1]};
        assert_true(options_read(wrong[i][1] ? 5 : 4, argv, &o, &fault) < 0);
        assert_string_equal(fault.pointer, wrong[i][0]);
    }
    assert_int_equal(options_read(1, good, &o, &fault), ERR_MISSING);
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tile_is_fetched_for_traced_and_answered),
        cmocka_unit_test(local_blobs_are_mapped_where_they_lie),
        cmocka_unit_test(a_cached_blob_is_not_fetched_again),
        cmocka_unit_test(results_are_kept_until_acknowledged),
        cmocka_unit_test(a_refusal_ends_the_worker),
        cmocka_unit_test(illegal_messages_break_the_link),
        cmocka_unit_test(a_missing_blob_is_a_fault_of_its_tiles),
        cmocka_unit_test(a_fetch_goes_on_after_a_reconnect),
        cmocka_unit_test(damaged_blobs_are_not_traced),
        cmocka_unit_test(a_map_is_fetched_beside_the_scene),
        cmocka_unit_test(a_missing_map_is_named),
        cmocka_unit_test(a_missing_scene_beside_a_map_is_named),
        cmocka_unit_test(blobs_of_the_wrong_kind_are_faults),
        cmocka_unit_test(a_cancelled_frame_lets_both_blobs_go),
        cmocka_unit_test(a_lease_names_its_pass),
        cmocka_unit_test(a_lease_has_its_pixels_sides),
        cmocka_unit_test(a_lease_has_its_lobes_sides),
        cmocka_unit_test(sides_that_do_not_fit_break_the_link),
        cmocka_unit_test(a_cancelled_frame_is_stopped),
        cmocka_unit_test(told_to_stop_it_finishes_what_it_traces),
        cmocka_unit_test(told_twice_it_leaves_at_once),
        cmocka_unit_test(a_drained_worker_asks_again_after_a_tile),
        cmocka_unit_test(with_its_parent_it_ends),
        cmocka_unit_test(beats_tell_of_progress),
        cmocka_unit_test(a_load_that_makes_no_step_ends_the_worker),
        cmocka_unit_test(one_that_spins_ends_it_sooner),
        cmocka_unit_test(a_long_load_that_makes_steps_does_not),
        cmocka_unit_test(nor_does_one_that_waits_for_a_thread),
        cmocka_unit_test(without_embree_there_is_no_worker),
        cmocka_unit_test(waits_double_up_to_five_seconds),
        cmocka_unit_test(addresses_are_checked),
        cmocka_unit_test(options_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
