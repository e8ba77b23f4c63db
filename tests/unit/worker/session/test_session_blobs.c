/* How a worker's session gets scenes and environment maps: from the coordinator in parts, from its
 * cache or from a folder of blobs; and what becomes of tiles whose blobs are missing or damaged. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/link/message.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/session/session_fixture.h"

ALL_TESTS(ignore_broken_pipes, NULL);

static void answer_none(struct world *w, struct digest digest)
{
    message_encode_blob_none(&w->w, &(struct message_blob_none){digest});
    put(w, MESSAGE_BLOB_NONE, NULL, 0);
}

TEST(local_blobs_are_mapped_where_they_lie)
{
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
    start_tile(w, 3);
    assert_int_equal(expect_result(w), 3); /* and no BLOB_GET */
    assert_int_not_equal(access(w->cache, F_OK), 0);
    world_close(w);
}

TEST(a_cached_blob_is_not_fetched_again)
{
    struct world *w = world_open(1, true); /* of blobs there is only an empty folder */
    warm_up(w);
    drop_link(w);
    struct session *old = w->session;
    struct fault fault = {0};
    const struct session_client client = {w, &w->worker_log, on_ended, NULL};
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

TEST(a_missing_blob_is_a_fault_of_its_tiles)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    start_tile(w, 1);
    expect(w, MESSAGE_BLOB_GET, &f);
    answer_none(w, w->plan.scene);
    assert_int_equal(expect_fault(w, ERR_NOT_FOUND, ""), 1);
    assert_true(told(w, "info work for a job", "trace=4bf92f3577b34da6a3ce929d0e0e4736"));
    assert_true(told(w, "warning tile cannot be traced", "job=job-nine frame_id=9 tile=1"));
    assert_true(told(w, "tile cannot be traced", "request=00f067aa0ba902b7"));
    send_tile(w, 9, 2); /* it tries again */
    serve_blob(w);
    assert_int_equal(expect_result(w), 2);
    world_close(w);
}

TEST(a_fetch_goes_on_after_a_reconnect)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    struct message_blob_get get;
    start_tile(w, 1);
    expect(w, MESSAGE_BLOB_GET, &f);
    const struct message_blob_part m = {
        .digest = w->plan.scene, .total_bytes = BLOB_BYTES, .size_bytes = LIMIT_BLOB_PART_BYTES};
    message_encode_blob_part(&w->w, &m);
    put(w, MESSAGE_BLOB_PART, w->blob, LIMIT_BLOB_PART_BYTES);
    expect(w, MESSAGE_BLOB_GET, &f);
    drop_link(w);
    start_tile(w, 1);
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

TEST(damaged_blobs_are_not_traced)
{
    struct world *w = world_open(1, false);
    start_tile(w, 1);
    w->blob[100] ^= 1;
    serve_blob(w);
    serve_blob(w); /* a second try, from the start */
    expect_fault(w, ERR_CHECKSUM, "");
    assert_int_equal(loads, 0);
    world_close(w);
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

/* A world with a map and a tile, whose first questions are taken. */
static struct world *start_with_map(struct message_blob_get *scene, struct message_blob_get *map)
{
    struct world *w = world_open(1, false);
    give_map(w);
    start_tile(w, 1);
    expect_both(w, scene, map);
    return w;
}

TEST(a_map_is_fetched_beside_the_scene)
{
    struct world *w = world_open(2, false);
    struct message_blob_get scene, map;
    give_map(w);
    start_tile(w, 3);
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

TEST(a_missing_map_is_named)
{
    struct message_blob_get scene, map;
    struct world *w = start_with_map(&scene, &map);
    answer_none(w, w->map_digest);
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

TEST(a_missing_scene_beside_a_map_is_named)
{
    struct message_blob_get scene, map;
    struct world *w = start_with_map(&scene, &map);
    answer(w, &map);
    for (int i = 0; loads == 0 && i < PATIENCE_MS; i++) turn(w);
    answer_none(w, w->plan.scene);
    expect_fault(w, ERR_NOT_FOUND, "scene: the coordinator does not have the blob");
    world_close(w);
}

TEST(blobs_of_the_wrong_kind_are_faults)
{
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

TEST(a_cancelled_frame_lets_both_blobs_go)
{
    struct message_blob_get scene, map;
    struct world *w = start_with_map(&scene, &map);
    message_encode_cancel(&w->w, &(struct message_cancel){9});
    put(w, MESSAGE_CANCEL, NULL, 0);
    expect_nothing(w);
    answer(w, &map);
    answer(w, &scene);
    expect_nothing(w);
    assert_int_equal(loads, 0);
    world_close(w);
}

/* Makes the world's scene a frame on a base, which takes the place of its map. */
static void stand_on_base(struct world *w, const char *magic)
{
    memcpy(w->map, magic, 8);
    digest_of(w->map, MAP_BYTES, &w->map_digest);
    memcpy(w->blob, FAKE_FRAME, 8);
    memcpy(w->blob + 8, &w->map_digest, sizeof w->map_digest);
    digest_of(w->blob, BLOB_BYTES, &w->plan.scene);
}

/* Another frame on the same base. */
static void change_frame(struct world *w)
{
    w->blob[BLOB_BYTES - 1]++;
    digest_of(w->blob, BLOB_BYTES, &w->plan.scene);
}

static void serve_base(struct world *w)
{
    struct message_blob_get get;
    expect_get(w, &get);
    assert_true(digest_equal(&get.digest, &w->map_digest));
    answer(w, &get);
}

TEST(frames_fetch_their_base_once)
{
    struct world *w = world_open(1, false);
    stand_on_base(w, FAKE_BASE);
    start_tile(w, 1);
    serve_blob(w);
    serve_base(w);
    assert_int_equal(expect_result(w), 1);
    assert_int_equal(loads, 2);
    change_frame(w);
    send_frame(w, 10);
    send_tile(w, 10, 2);
    serve_blob(w);
    assert_int_equal(expect_result(w), 2); /* and no question for the base */
    assert_int_equal(loads, 3);
    world_close(w);
}

TEST(frames_on_a_base_that_is_none_are_faults)
{
    struct world *w = world_open(1, false);
    stand_on_base(w, "NOTABASE");
    start_tile(w, 1);
    serve_blob(w);
    serve_base(w);
    expect_fault(w, ERR_MISMATCH, "scene: base: the blob that it stands on is no base of frames");
    world_close(w);
}

TEST(frames_whose_base_lacks_memory_are_faults_and_end_the_worker)
{
    struct world *w = world_open(1, false);
    struct wire_frame_view f;
    stand_on_base(w, FAKE_BASE);
    load_error = ERR_MEMORY;
    load_error_of_base = true;
    start_tile(w, 1);
    serve_blob(w);
    serve_base(w);
    expect_fault(w, ERR_MEMORY, "scene: base: scene: the fake gives it up");
    expect(w, MESSAGE_BYE, &f);
    assert_int_equal(w->end, SESSION_END_FAILED);
    load_error = 0;
    load_error_of_base = false;
    world_close(w);
}

TEST(frames_whose_base_is_missing_are_faults)
{
    struct world *w = world_open(1, false);
    struct message_blob_get get;
    stand_on_base(w, FAKE_BASE);
    start_tile(w, 1);
    serve_blob(w);
    expect_get(w, &get);
    answer_none(w, w->map_digest);
    expect_fault(w, ERR_NOT_FOUND, "scene: base: the coordinator does not have the blob");
    send_tile(w, 9, 2); /* it tries again */
    serve_base(w);
    assert_int_equal(expect_result(w), 2);
    world_close(w);
}

TEST(bases_are_no_scenes)
{
    struct world *w = world_open(1, false);
    stand_on_base(w, FAKE_BASE);
    w->plan.scene = w->map_digest;
    start_tile(w, 1);
    serve_base(w);
    expect_fault(w, ERR_MAGIC, "scene: this is a base of frames");
    world_close(w);
}
