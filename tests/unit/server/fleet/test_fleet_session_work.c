/* What a fleet's sessions hand out and take back: tiles, their results and verdicts, blobs. */
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>

#include "proto/link/wire_frame.h"
#include "tests/unit/server/fleet/fleet_fixture.h"
#include "tests/unit/server/fleet/fleet_peer.h"
#include "tests/unit/unit.h"

ALL_TESTS(ignore_broken_pipes, NULL);

TEST(a_tile_goes_out_and_its_result_in)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct wire_frame_view f;
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

TEST(waiting_workers_are_served_on_a_wake)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct wire_frame_view f;
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

TEST(late_verdicts_and_cancelled_frames)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct wire_frame_view f;
    struct message_tile tile, other;
    peer_start(&p, 2, 2, &tile);
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

TEST(foreign_and_old_results_do_not_pass_as_leases)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct message_tile tile, other;
    w->generation = 5;
    w->verdict = VERDICT_STALE;
    peer_start(&p, 1, 1, &tile);
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

TEST(given_back_and_faulted_tiles_reach_the_client)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct wire_frame_view f;
    struct message_tile tile;
    peer_start(&p, 2, 2, &tile);
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

TEST(a_stalled_tile_is_taken_back)
{
    /* Far longer than a turn may take while others use the machine. */
    struct world *w = world_open(LONG_MS, 1000);
    struct peer p = peer_open(w);
    struct message_tile tile;
    peer_start(&p, 2, 1, &tile);
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

TEST(unacknowledged_results_stop_the_reading)
{
    enum { BYTES = 12 << 20, TILES = 4 };
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct wire_frame_view f;
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
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    wire_frame_header(header, MESSAGE_RESULT, 1, p.w.data, (uint32_t)p.w.size_bytes, samples,
                      BYTES);
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

TEST(blobs_are_served_in_parts)
{
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
        struct wire_frame_view f;
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
    struct wire_frame_view f;
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

TEST(draining_workers_get_nothing)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    struct wire_frame_view f;
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
