/* Events of a job: ids, replay, what slow readers miss and what they must not. */
#include <stdio.h>
#include <string.h>

#include "proto/limits.h"
#include "server/stream/events.h"
#include "tests/unit/unit.h"

#define EPOCH 0x2au

static void push(struct event_ring *ring, const char *name, int value)
{
    json_t *data = json_pack("{s:i}", "v", value);
    assert_int_equal(event_ring_push(ring, name, data), 0);
    json_decref(data);
}

/* The next event's bytes must be these. */
static void expect_next(const struct event_ring *ring, uint64_t *cursor, uint64_t id,
                        const char *name, int value)
{
    char want[128];
    struct event_text *text = event_ring_next(ring, cursor);
    assert_non_null(text);
    int n = snprintf(want, sizeof want, "id: 0000002a-%llu\nevent: %s\ndata: {\"v\":%d}\n\n",
                     (unsigned long long)id, name, value);
    assert_int_equal(text->size_bytes, n);
    assert_memory_equal(text->bytes, want, (size_t)n);
    assert_int_equal(*cursor, id);
    event_text_unref(&text);
    assert_null(text);
}

static void expect_end(const struct event_ring *ring, uint64_t cursor)
{
    assert_false(event_ring_pending(ring, cursor));
    assert_null(event_ring_next(ring, &cursor));
}

TEST(empty_ring)
{
    struct event_ring ring;
    event_ring_init(&ring, EPOCH);
    expect_end(&ring, 0);
    assert_true(event_ring_has_after(&ring, 0));
    assert_false(event_ring_has_after(&ring, 1)); /* an id that was never given */
    event_ring_fini(&ring);
}

TEST(ids_grow_by_one)
{
    struct event_ring ring;
    uint64_t cursor = 0;
    event_ring_init(&ring, EPOCH);
    for (int i = 1; i <= 40; i++) push(&ring, "state", i);
    for (int i = 1; i <= 40; i++) expect_next(&ring, &cursor, (uint64_t)i, "state", i);
    expect_end(&ring, cursor);
    cursor = 37; /* a replay from the middle */
    expect_next(&ring, &cursor, 38, "state", 38);
    event_ring_fini(&ring);
}

TEST(slow_readers_skip_old_progress)
{
    struct event_ring ring;
    uint64_t cursor = 0;
    event_ring_init(&ring, EPOCH);
    push(&ring, "progress", 1);
    push(&ring, "tile", 2);
    push(&ring, "state", 3);
    push(&ring, "progress", 4);
    push(&ring, "tile", 5);
    expect_next(&ring, &cursor, 3, "state", 3);
    expect_next(&ring, &cursor, 4, "progress", 4);
    expect_next(&ring, &cursor, 5, "tile", 5);
    expect_end(&ring, cursor);
    push(&ring, "progress", 6); /* a quick reader gets each */
    expect_next(&ring, &cursor, 6, "progress", 6);
    event_ring_fini(&ring);
}

TEST(lost_events_are_noticed)
{
    struct event_ring ring;
    event_ring_init(&ring, EPOCH);
    push(&ring, "state", 0);
    for (int i = 0; i < LIMIT_EVENT_RING; i++) push(&ring, "progress", i);
    assert_int_equal(ring.count, LIMIT_EVENT_RING);
    assert_false(event_ring_has_after(&ring, 0)); /* the state event is gone */
    assert_true(event_ring_has_after(&ring, 1));
    for (int i = 0; i < 10; i++) push(&ring, "progress", i);
    assert_true(event_ring_has_after(&ring, 1)); /* only progress was lost since */
    uint64_t cursor = 1;
    expect_next(&ring, &cursor, LIMIT_EVENT_RING + 11, "progress", 9);
    expect_end(&ring, cursor);
    event_ring_fini(&ring);
}

TEST(held_text_outlives_the_ring)
{
    struct event_ring ring;
    uint64_t cursor = 0;
    event_ring_init(&ring, EPOCH);
    push(&ring, "state", 7);
    struct event_text *text = event_ring_next(&ring, &cursor);
    for (int i = 0; i < 2 * LIMIT_EVENT_RING; i++) push(&ring, "state", i);
    event_ring_fini(&ring);
    assert_int_equal(text->refs, 1);
    assert_non_null(strstr(text->bytes, "{\"v\":7}"));
    event_text_unref(&text);
}

TEST(data_is_one_line)
{
    json_t *data = json_pack("{s:s}", "text", "a\nb\r\nevent: forged\n\ndata: x");
    struct event_text *text = event_text_create(EPOCH, 1, "error", data);
    assert_non_null(text);
    size_t lines = 0;
    for (size_t i = 0; i < text->size_bytes; i++) {
        lines += text->bytes[i] == '\n';
        assert_int_not_equal(text->bytes[i], '\r');
    }
    assert_int_equal(lines, 4); /* id, event, data, blank */
    event_text_unref(&text);
    json_decref(data);
}

TEST(ids_of_another_life_are_none)
{
    assert_int_equal(event_id_read(EPOCH, "0000002a-17"), 17);
    static const char *const bad[] = {
        "",           "17",          "0000002b-17", "0000002a-",
        "0000002a-x", "0000002a-1x", "0000002a--1", "0000002a-99999999999999999999"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(event_id_read(EPOCH, bad[i]), 0);
}
