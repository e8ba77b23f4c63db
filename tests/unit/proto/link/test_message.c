/* Messages: each survives the way over the wire, anything else is refused, and the bytes of each
 * are those of tests/golden/wire for ever. */
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/proto/link/message_cases.h"
#include "tests/unit/unit.h"

static void payload_of(const struct message_case *c, struct bytes_writer *w)
{
    union message_any m;
    bytes_writer_init(w);
    c->fill(&m);
    case_payload(c, &m, w);
    assert_false(w->failed);
}

TEST(round_trips)
{
    for (const struct message_case *c = message_cases; c < message_cases + MESSAGE_CASES; c++) {
        struct bytes_writer w;
        union message_any sent, got;
        const uint8_t *sent_range, *got_range;
        uint32_t sent_bytes, got_bytes;
        payload_of(c, &w);
        memset(&got, 0xee, sizeof got); /* decoders must set all */
        assert_int_equal(c->decode(w.data, w.size_bytes, &got), ERR_OK);
        c->fill(&sent);
        c->range(&sent, &sent_range, &sent_bytes);
        c->range(&got, &got_range, &got_bytes);
        assert_int_equal(sent_bytes, got_bytes);
        if (sent_bytes > 0) assert_memory_equal(sent_range, got_range, sent_bytes);
        assert_memory_equal(&sent, &got, c->struct_bytes);
        bytes_writer_fini(&w);
    }
}

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
static int decode_exact(const struct message_case *c, const uint8_t *data, size_t size_bytes)
{
    union message_any m;
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    int code = c->decode(exact, size_bytes, &m);
    free(exact);
    return code;
}

TEST(truncations_fail)
{
    for (const struct message_case *c = message_cases; c < message_cases + MESSAGE_CASES; c++) {
        struct bytes_writer w;
        payload_of(c, &w);
        size_t fixed_bytes = c->has_tail ? w.size_bytes - sizeof case_bytes : w.size_bytes;
        for (size_t size_bytes = 0; size_bytes < w.size_bytes; size_bytes++) {
            int code = decode_exact(c, w.data, size_bytes);
            if (size_bytes < fixed_bytes && code != ERR_TRUNCATED)
                fail_msg("%s cut to %zu bytes gives %s", c->name, size_bytes, error_name(code));
        }
        bytes_writer_fini(&w);
    }
}

TEST(trailing_bytes_fail)
{
    for (const struct message_case *c = message_cases; c < message_cases + MESSAGE_CASES; c++) {
        struct bytes_writer w;
        payload_of(c, &w);
        bytes_write_u8(&w, 0);
        int code = decode_exact(c, w.data, w.size_bytes);
        /* RESULT's samples end with the payload; a part would reach beyond its blob. */
        int expected = ERR_TRAILING;
        if (c->number == MESSAGE_RESULT) expected = ERR_OK;
        if (c->number == MESSAGE_BLOB_PART) expected = ERR_RANGE;
        if (code != expected) fail_msg("%s with a byte more gives %s", c->name, error_name(code));
        bytes_writer_fini(&w);
    }
}

/* Any single damaged byte is either refused or means something that encodes to just these bytes. */
TEST(damage_is_refused_or_means_itself)
{
    for (const struct message_case *c = message_cases; c < message_cases + MESSAGE_CASES; c++) {
        struct bytes_writer w, again;
        union message_any m;
        payload_of(c, &w);
        for (size_t bit = 0; bit < 8 * w.size_bytes; bit++) {
            w.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
            if (c->decode(w.data, w.size_bytes, &m) == ERR_OK) {
                bytes_writer_init(&again);
                case_payload(c, &m, &again);
                assert_int_equal(again.size_bytes, w.size_bytes);
                assert_memory_equal(again.data, w.data, w.size_bytes);
                bytes_writer_fini(&again);
            }
            w.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        }
        bytes_writer_fini(&w);
    }
}

/* Encodes *m, decodes it, and expects `code`. */
#define EXPECT(type, m, code)                                                                      \
    do {                                                                                           \
        struct bytes_writer w_;                                                                    \
        struct message_##type back_;                                                               \
        bytes_writer_init(&w_);                                                                    \
        message_encode_##type(&w_, (m));                                                           \
        assert_int_equal(message_decode_##type(w_.data, w_.size_bytes, &back_), (code));           \
        bytes_writer_fini(&w_);                                                                    \
    } while (0)

/* Starts from the message's case, changes one thing, and expects `code`. */
#define EXPECT_WITH(type, change, code)                                                            \
    do {                                                                                           \
        struct message_##type m;                                                                   \
        fill_##type(&m);                                                                           \
        change;                                                                                    \
        EXPECT(type, &m, code);                                                                    \
    } while (0)

TEST(session_values)
{
    EXPECT_WITH(hello, m.threads = 0, ERR_RANGE);
    EXPECT_WITH(hello, m.threads = LIMIT_THREADS, ERR_OK);
    EXPECT_WITH(hello, m.threads = LIMIT_THREADS + 1, ERR_LIMIT);
    EXPECT_WITH(hello, m.capabilities = UINT32_MAX,
                ERR_OK); /* append-only: unknown bits are fine */
    EXPECT_WITH(welcome, m.beat_ms = 0, ERR_RANGE);
    EXPECT_WITH(refused, m.code = 0, ERR_RANGE);
    EXPECT_WITH(refused, m.code = 5, ERR_RANGE);
    EXPECT_WITH(refused, m.code = INT32_MIN, ERR_OK);
    EXPECT_WITH(want, m.tiles = 0, ERR_OK);
    EXPECT_WITH(want, m.tiles = LIMIT_TILES_IN_HAND, ERR_OK);
    EXPECT_WITH(want, m.tiles = LIMIT_TILES_IN_HAND + 1, ERR_LIMIT);
    EXPECT_WITH(beat, m.phase = 3, ERR_RANGE);
    EXPECT_WITH(beat, m.tiles_in_hand = LIMIT_TILES_IN_HAND + 1, ERR_LIMIT);
    EXPECT_WITH(drain, m.reserved = 1, ERR_RANGE);
    EXPECT_WITH(bye, m.reserved = 1, ERR_RANGE);
}

TEST(tile_values)
{
    EXPECT_WITH(tile, m.pass.number = LIMIT_PASSES, ERR_LIMIT);
    EXPECT_WITH(tile, m.pass.first = LIMIT_SPP + 1, ERR_LIMIT);
    EXPECT_WITH(tile, m.pass.count = LIMIT_PASS_LENS_SAMPLES + 1, ERR_LIMIT);
    EXPECT_WITH(tile, m.pass.strata = LIMIT_STRATA_PER_AXIS + 1, ERR_LIMIT);
    EXPECT_WITH(tile, m.pass = ((struct plan_pass){3, 0, 0, 0, NULL, NULL}), ERR_OK);
    EXPECT_WITH(tile, m.counts_bytes = 0, ERR_OK);
    EXPECT_WITH(tile, m.rect.x0 = -1, ERR_RANGE);
    EXPECT_WITH(tile, m.rect.y0 = INT32_MIN, ERR_RANGE);
    EXPECT_WITH(tile, m.rect.x0 = m.rect.x1, ERR_RANGE);
    EXPECT_WITH(tile, m.rect.y1 = m.rect.y0 - 1, ERR_RANGE);
    EXPECT_WITH(tile, m.rect.x1 = LIMIT_IMAGE_SIDE_PX + 1, ERR_LIMIT);
    EXPECT_WITH(tile, m.rect.y1 = INT32_MAX, ERR_LIMIT);
    EXPECT_WITH(tile, m.rect = ((struct rect){0, 0, LIMIT_TILE_SIDE_PX, LIMIT_TILE_SIDE_PX}),
                ERR_OK);
    EXPECT_WITH(tile, m.rect = ((struct rect){0, 0, LIMIT_TILE_SIDE_PX + 1, 8}), ERR_LIMIT);
    EXPECT_WITH(tile, m.rect = ((struct rect){0, 0, 8, LIMIT_TILE_SIDE_PX + 1}), ERR_LIMIT);
    EXPECT_WITH(tile, m.index = 4194303, ERR_OK);
    EXPECT_WITH(tile, m.index = 4194304, ERR_LIMIT);
    EXPECT_WITH(result, m.index = UINT32_MAX, ERR_LIMIT);
    EXPECT_WITH(returned, m.index = UINT32_MAX, ERR_LIMIT);
    EXPECT_WITH(ack, m.index = UINT32_MAX, ERR_LIMIT);
    EXPECT_WITH(ack, m.verdict = 0, ERR_RANGE);
    EXPECT_WITH(ack, m.verdict = VERDICT_CORRUPT + 1, ERR_RANGE);
    EXPECT_WITH(tile_fault, m.code = 0, ERR_RANGE);
    EXPECT_WITH(tile_fault, m.index = UINT32_MAX, ERR_LIMIT);
    EXPECT_WITH(frame_plan, m.plan_bytes = 0, ERR_OK); /* for plan_decode to refuse */
    EXPECT_WITH(frame_plan, m.job[0] = m.trace[0] = '\0', ERR_OK);
}

static int decode_part(uint64_t total_bytes, uint64_t offset, size_t size_bytes)
{
    struct message_blob_part m = {.total_bytes = total_bytes, .offset = offset}, back;
    struct bytes_writer w;
    bytes_writer_init(&w);
    message_encode_blob_part(&w, &m);
    uint8_t *tail = bytes_extend(&w, size_bytes);
    assert_non_null(tail);
    memset(tail, 7, size_bytes);
    int code = message_decode_blob_part(w.data, w.size_bytes, &back);
    bytes_writer_fini(&w);
    return code;
}

TEST(blob_values)
{
    EXPECT_WITH(blob_get, m.size_bytes = 0, ERR_RANGE);
    EXPECT_WITH(blob_get, m.size_bytes = LIMIT_BLOB_PART_BYTES + 1, ERR_LIMIT);
    EXPECT_WITH(blob_get, m.offset = LIMIT_BLOB_BYTES, ERR_LIMIT);
    assert_int_equal(decode_part(10, 0, 10), ERR_OK);
    assert_int_equal(decode_part(10, 9, 1), ERR_OK);
    assert_int_equal(decode_part(10, 0, 0), ERR_RANGE);
    assert_int_equal(decode_part(0, 0, 0), ERR_RANGE);
    assert_int_equal(decode_part(10, 9, 2), ERR_RANGE);
    assert_int_equal(decode_part(10, 10, 1), ERR_RANGE);
    assert_int_equal(decode_part(10, UINT64_MAX, 2), ERR_RANGE);
    assert_int_equal(decode_part(LIMIT_BLOB_BYTES, 0, 1), ERR_OK);
    assert_int_equal(decode_part(LIMIT_BLOB_BYTES + 1, 0, 1), ERR_LIMIT);
    assert_int_equal(decode_part(LIMIT_BLOB_BYTES, 0, LIMIT_BLOB_PART_BYTES), ERR_OK);
    assert_int_equal(decode_part(LIMIT_BLOB_BYTES, 0, LIMIT_BLOB_PART_BYTES + 1), ERR_LIMIT);
}

/* Writes number-value pairs by hand behind a lease. */
static int decode_counters(const uint16_t *numbers, const uint64_t *values, uint16_t count)
{
    struct message_result back;
    struct bytes_writer w;
    bytes_writer_init(&w);
    bytes_write_u64(&w, 1);
    bytes_write_u32(&w, 2);
    bytes_write_u32(&w, 3);
    bytes_write_u16(&w, count);
    for (uint16_t i = 0; i < count; i++) {
        bytes_write_u16(&w, numbers[i]);
        bytes_write_u64(&w, values[i]);
    }
    int code = message_decode_result(w.data, w.size_bytes, &back);
    bytes_writer_fini(&w);
    return code;
}

TEST(counter_values)
{
    static const uint64_t ones[COUNTER_COUNT + 1] = {1, 1, 1}, zero[] = {0};
    assert_int_equal(decode_counters((uint16_t[]){0, 1, 2}, ones, 3), ERR_OK);
    assert_int_equal(decode_counters(NULL, NULL, 0), ERR_OK);
    assert_int_equal(decode_counters((uint16_t[]){1, 1}, ones, 2), ERR_RANGE);
    assert_int_equal(decode_counters((uint16_t[]){2, 1}, ones, 2), ERR_RANGE);
    assert_int_equal(decode_counters((uint16_t[]){COUNTER_COUNT}, ones, 1), ERR_RANGE);
    assert_int_equal(decode_counters((uint16_t[]){0}, zero, 1), ERR_RANGE);
    static const uint16_t many[COUNTER_COUNT + 1];
    assert_int_equal(decode_counters(many, ones, COUNTER_COUNT + 1), ERR_LIMIT);
}

TEST(counters_saturate)
{
    struct counters sum = {{0}}, more = {{0}};
    sum.value[0] = UINT64_MAX - 1;
    more.value[0] = 5;
    sum.value[1] = 7;
    more.value[1] = 8;
    counters_add(&sum, &more);
    assert_true(sum.value[0] == UINT64_MAX);
    assert_true(sum.value[1] == 15);
    assert_string_equal(counter_group(COUNTER_RAYS_PRIMARY), "rays");
    assert_string_equal(counter_key(COUNTER_SKIPPED_BELOW_HORIZON), "light_below_horizon");
    assert_true(strlen(counter_text(COUNTER_BUILD_CPU_US)) > 0);
}

static int decode_refused_text(const char *text, size_t size_bytes)
{
    struct message_refused back;
    struct bytes_writer w;
    bytes_writer_init(&w);
    bytes_write_u32(&w, (uint32_t)ERR_VERSION);
    bytes_write_u16(&w, (uint16_t)size_bytes);
    bytes_write_raw(&w, text, size_bytes);
    int code = message_decode_refused(w.data, w.size_bytes, &back);
    bytes_writer_fini(&w);
    return code;
}

/* What a text may hold reaches logs, terminals and JSON. */
TEST(texts_are_printable_utf8)
{
    static const char *const good[] = {"",
                                       "plain",
                                       "\xc3\xa9",
                                       "\xe2\x82\xac",
                                       "\xf0\x9f\x98\x80",
                                       "\xed\x9f\xbf",
                                       "\xee\x80\x80",
                                       "\xf4\x8f\xbf\xbf"};
    static const char *const bad[] = {"\n",
                                      "\x1b[31m",
                                      "\x7f",
                                      "\xc2\x80",
                                      "\xc2\x9f",
                                      "\x80",
                                      "\xc0\xaf",
                                      "\xc1\xbf",
                                      "\xe0\x80\xaf",
                                      "\xed\xa0\x80",
                                      "\xf0\x80\x80\xaf",
                                      "\xf4\x90\x80\x80",
                                      "\xf5\x80\x80\x80",
                                      "\xff",
                                      "a\xc3",
                                      "a\xe2\x82",
                                      "\xe2\x28\xa1",
                                      "\xf0\x9f\x98",
                                      "\xf0\x9f\x28\x80"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        assert_int_equal(decode_refused_text(good[i], strlen(good[i])), ERR_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(decode_refused_text(bad[i], strlen(bad[i])), ERR_RANGE);
    assert_int_equal(decode_refused_text("a\0b", 3), ERR_TRUNCATED);
    char text[LIMIT_DETAIL_BYTES];
    memset(text, 'x', sizeof text);
    assert_int_equal(decode_refused_text(text, sizeof text - 1), ERR_OK);
    assert_int_equal(decode_refused_text(text, sizeof text), ERR_TRUNCATED);
}

/* Encoders send nothing that decoders refuse. */
TEST(texts_are_cleaned)
{
    struct message_refused m = {.code = ERR_IO}, back;
    struct bytes_writer w;
    bytes_writer_init(&w);
    strcpy(m.text, "a\nb\xff \xe2\x82\xac \xe2\x82");
    message_encode_refused(&w, &m);
    assert_int_equal(message_decode_refused(w.data, w.size_bytes, &back), ERR_OK);
    assert_string_equal(back.text, "a?b? \xe2\x82\xac ??");
    bytes_writer_fini(&w);

    memset(m.text, 0xe2, sizeof m.text); /* without an end */
    message_encode_refused(&w, &m);
    assert_int_equal(message_decode_refused(w.data, w.size_bytes, &back), ERR_OK);
    assert_int_equal(strlen(back.text), LIMIT_DETAIL_BYTES - 1);
    bytes_writer_fini(&w);
}

/* A worker of another version must be told so, whatever else its HELLO holds. */
TEST(other_versions_are_readable)
{
    struct message_hello m;
    static const uint8_t newer[] = {99, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 0xff};
    for (size_t size_bytes = 4; size_bytes <= sizeof newer; size_bytes++) {
        assert_int_equal(message_decode_hello(newer, size_bytes, &m), ERR_VERSION);
        assert_int_equal(m.protocol_version, 99);
        assert_int_equal(m.threads, 0);
        assert_string_equal(m.build_id, "");
    }
    assert_int_equal(message_decode_hello(newer, 3, &m), ERR_TRUNCATED);
}

TEST(names_and_numbers)
{
    assert_null(message_name(0));
    assert_null(message_name(UINT16_MAX));
    for (size_t i = 0; i < MESSAGE_CASES; i++) {
        assert_int_equal(message_cases[i].number, i + 1); /* append-only: no gaps, no reordering */
        assert_string_equal(message_name(message_cases[i].number), message_cases[i].name);
    }
    assert_int_equal(MESSAGE_HELLO, 1);
    assert_int_equal(MESSAGE_FAULT, 17);
}

#define GOLDEN "tests/golden/wire"

static size_t read_golden(const char *path, uint8_t *out, size_t capacity)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) fail_msg("%s cannot be read (the working directory is the repository)", path);
    size_t size_bytes = fread(out, 1, capacity, file);
    fclose(file);
    return size_bytes;
}

static void write_golden(const char *path, const struct bytes_writer *w)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(w->data, 1, w->size_bytes, file), w->size_bytes);
    assert_int_equal(fclose(file), 0);
}

/* A message's bytes never change: a change needs a new message, or a new PROTOCOL_VERSION. Then,
 * and for a message that was added, from the repository's root: SHEARWATER_WRITE_GOLDEN=1
 * build/tests/unit/proto/test_message and say in the commit why. */
TEST(bytes_are_golden)
{
    for (const struct message_case *c = message_cases; c < message_cases + MESSAGE_CASES; c++) {
        struct bytes_writer w;
        char path[256];
        uint8_t golden[4096];
        payload_of(c, &w);
        snprintf(path, sizeof path, "%s/%s.bin", GOLDEN, c->name);
        if (getenv("SHEARWATER_WRITE_GOLDEN") != NULL) write_golden(path, &w);
        size_t golden_bytes = read_golden(path, golden, sizeof golden);
        if (golden_bytes != w.size_bytes || memcmp(golden, w.data, golden_bytes) != 0)
            fail_msg("%s no longer encodes to the bytes of %s: see the comment above this test",
                     c->name, path);
        bytes_writer_fini(&w);
    }
}
