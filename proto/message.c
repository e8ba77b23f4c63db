#include "proto/message.h"

#include <string.h>

#include "proto/count_map.h"

/* Encoders write what decoders accept: texts are cleaned on the way out and refused unclean on the
 * way in. Decoders zero the struct first, read all fields, ask once whether the payload had exactly
 * the right size, then check the values. */

/* Largest index of a tile plus one: the finest grid over the largest image. */
#define TILE_INDEX_END                                                                             \
    ((LIMIT_IMAGE_SIDE_PX / LIMIT_TILE_SIDE_MIN_PX) *                                              \
     (LIMIT_IMAGE_SIDE_PX / LIMIT_TILE_SIDE_MIN_PX))

const char *message_name(uint16_t type)
{
    switch (type) {
#define MESSAGE(name, number, type, sender, text)                                                  \
    case number:                                                                                   \
        return #name;
#include "proto/message.def"
#undef MESSAGE
    default:
        return NULL;
    }
}

/* Bytes of the UTF-8 character at `at` (which ends with a NUL), 0 if it is none or a control
 * character. Unicode 15, table 3-7. */
static size_t character_bytes(const char *at)
{
    const unsigned char *c = (const unsigned char *)at;
    if (c[0] >= 0x20 && c[0] < 0x7f) return 1;
    if (c[0] < 0xc2 || c[0] > 0xf4) return 0;
    unsigned char low = 0x80, high = 0xbf;
    if (c[0] == 0xc2) low = 0xa0; /* below are control characters */
    if (c[0] == 0xe0) low = 0xa0;
    if (c[0] == 0xed) high = 0x9f;
    if (c[0] == 0xf0) low = 0x90;
    if (c[0] == 0xf4) high = 0x8f;
    if (c[1] < low || c[1] > high) return 0;
    size_t size_bytes = c[0] < 0xe0 ? 2 : c[0] < 0xf0 ? 3 : 4;
    for (size_t i = 2; i < size_bytes; i++)
        if ((c[i] & 0xc0) != 0x80) return 0;
    return size_bytes;
}

/* Texts reach logs, terminals and JSON: only printable UTF-8 travels. */
static bool text_is_clean(const char *text)
{
    while (*text != '\0') {
        size_t size_bytes = character_bytes(text);
        if (size_bytes == 0) return false;
        text += size_bytes;
    }
    return true;
}

/* capacity is at most LIMIT_DETAIL_BYTES. */
static void write_text(struct bytes_writer *w, const char *text, size_t capacity)
{
    char clean[LIMIT_DETAIL_BYTES];
    size_t length = strnlen(text, capacity - 1);
    memcpy(clean, text, length);
    clean[length] = '\0';
    for (size_t i = 0; i < length;) {
        size_t size_bytes = character_bytes(clean + i);
        if (size_bytes == 0) clean[i] = '?';
        i += size_bytes != 0 ? size_bytes : 1;
    }
    bytes_write_string(w, clean);
}

static void write_i32(struct bytes_writer *w, int32_t v)
{
    bytes_write_u32(w, (uint32_t)v);
}

static int32_t read_i32(struct bytes_reader *r)
{
    return (int32_t)bytes_read_u32(r);
}

static void write_digest(struct bytes_writer *w, const struct digest *d)
{
    bytes_write_raw(w, d->bytes, DIGEST_BYTES);
}

static void read_digest(struct bytes_reader *r, struct digest *d)
{
    bytes_read_raw(r, d->bytes, DIGEST_BYTES);
}

/* The rest of the payload, for the two messages that end in a byte range. */
static int read_tail(struct bytes_reader *r, const uint8_t **bytes, uint32_t *size_bytes)
{
    size_t left_bytes = bytes_left(r);
    if (left_bytes > LIMIT_FRAME_BYTES) return ERR_LIMIT;
    *bytes = bytes_borrow(r, left_bytes);
    *size_bytes = (uint32_t)left_bytes;
    return ERR_OK;
}

/* Frame, index and generation: what names a lease. */
static void write_lease(struct bytes_writer *w, uint64_t frame_id, uint32_t index,
                        uint32_t generation)
{
    bytes_write_u64(w, frame_id);
    bytes_write_u32(w, index);
    bytes_write_u32(w, generation);
}

static void read_lease(struct bytes_reader *r, uint64_t *frame_id, uint32_t *index,
                       uint32_t *generation)
{
    *frame_id = bytes_read_u64(r);
    *index = bytes_read_u32(r);
    *generation = bytes_read_u32(r);
}

static int check_index(uint32_t index)
{
    return index < TILE_INDEX_END ? ERR_OK : ERR_LIMIT;
}

void message_encode_hello(struct bytes_writer *w, const struct message_hello *m)
{
    bytes_write_u32(w, m->protocol_version);
    bytes_write_u32(w, m->capabilities);
    write_text(w, m->build_id, sizeof m->build_id);
    write_text(w, m->embree_version, sizeof m->embree_version);
    write_text(w, m->isa, sizeof m->isa);
    write_text(w, m->name, sizeof m->name);
    bytes_write_u32(w, m->threads);
    bytes_write_u64(w, m->pid);
}

static int check_hello(const struct message_hello *m)
{
    if (m->threads > LIMIT_THREADS) return ERR_LIMIT;
    if (m->threads == 0) return ERR_RANGE;
    if (!text_is_clean(m->build_id) || !text_is_clean(m->embree_version)) return ERR_RANGE;
    if (!text_is_clean(m->isa) || !text_is_clean(m->name)) return ERR_RANGE;
    return ERR_OK;
}

int message_decode_hello(const void *payload, size_t size_bytes, struct message_hello *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    m->protocol_version = bytes_read_u32(&r);
    /* Of another version's HELLO only the number is sure, and it is all that a refusal needs. */
    if (!r.failed && m->protocol_version != PROTOCOL_VERSION) return ERR_VERSION;
    m->capabilities = bytes_read_u32(&r);
    bytes_read_string(&r, m->build_id, sizeof m->build_id);
    bytes_read_string(&r, m->embree_version, sizeof m->embree_version);
    bytes_read_string(&r, m->isa, sizeof m->isa);
    bytes_read_string(&r, m->name, sizeof m->name);
    m->threads = bytes_read_u32(&r);
    m->pid = bytes_read_u64(&r);
    int code = bytes_finish(&r);
    return code != ERR_OK ? code : check_hello(m);
}

void message_encode_welcome(struct bytes_writer *w, const struct message_welcome *m)
{
    bytes_write_u64(w, m->worker_id);
    bytes_write_u32(w, m->beat_ms);
}

int message_decode_welcome(const void *payload, size_t size_bytes, struct message_welcome *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    m->worker_id = bytes_read_u64(&r);
    m->beat_ms = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return m->beat_ms != 0 ? ERR_OK : ERR_RANGE;
}

void message_encode_refused(struct bytes_writer *w, const struct message_refused *m)
{
    write_i32(w, m->code);
    write_text(w, m->text, sizeof m->text);
}

int message_decode_refused(const void *payload, size_t size_bytes, struct message_refused *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    m->code = read_i32(&r);
    bytes_read_string(&r, m->text, sizeof m->text);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return m->code < 0 && text_is_clean(m->text) ? ERR_OK : ERR_RANGE;
}

void message_encode_want(struct bytes_writer *w, const struct message_want *m)
{
    bytes_write_u32(w, m->tiles);
}

int message_decode_want(const void *payload, size_t size_bytes, struct message_want *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    m->tiles = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return m->tiles <= LIMIT_TILES_IN_HAND ? ERR_OK : ERR_LIMIT;
}

void message_encode_frame_plan(struct bytes_writer *w, const struct message_frame_plan *m)
{
    bytes_write_u64(w, m->frame_id);
    write_text(w, m->job, sizeof m->job);
    write_text(w, m->trace, sizeof m->trace);
    bytes_write_u32(w, m->plan_bytes);
    bytes_write_raw(w, m->plan, m->plan_bytes);
}

int message_decode_frame_plan(const void *payload, size_t size_bytes, struct message_frame_plan *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    m->frame_id = bytes_read_u64(&r);
    bytes_read_string(&r, m->job, sizeof m->job);
    bytes_read_string(&r, m->trace, sizeof m->trace);
    m->plan_bytes = bytes_read_u32(&r);
    if (!r.failed && m->plan_bytes > LIMIT_FRAME_BYTES) return ERR_LIMIT;
    m->plan = bytes_borrow(&r, m->plan_bytes);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return text_is_clean(m->job) && text_is_clean(m->trace) ? ERR_OK : ERR_RANGE;
}

void message_encode_tile(struct bytes_writer *w, const struct message_tile *m)
{
    write_lease(w, m->frame_id, m->index, m->generation);
    bytes_write_u32(w, m->pass.number);
    bytes_write_u32(w, m->pass.first);
    bytes_write_u32(w, m->pass.count);
    bytes_write_u32(w, m->pass.strata);
    write_i32(w, m->rect.x0);
    write_i32(w, m->rect.y0);
    write_i32(w, m->rect.x1);
    write_i32(w, m->rect.y1);
    bytes_write_u32(w, m->counts_bytes);
    bytes_write_raw(w, m->counts, m->counts_bytes);
}

static int check_pass(const struct plan_pass *pass)
{
    if (pass->number >= LIMIT_PASSES || pass->first > LIMIT_SPP) return ERR_LIMIT;
    return pass->count > LIMIT_PASS_SPP || pass->strata > LIMIT_STRATA_PER_AXIS ? ERR_LIMIT : 0;
}

static int check_rect(struct rect rect)
{
    if (rect.x0 < 0 || rect.y0 < 0 || rect_is_empty(rect)) return ERR_RANGE;
    if (rect.x1 > LIMIT_IMAGE_SIDE_PX || rect.y1 > LIMIT_IMAGE_SIDE_PX) return ERR_LIMIT;
    if (rect_width(rect) > LIMIT_TILE_SIDE_PX) return ERR_LIMIT;
    if (rect_height(rect) > LIMIT_TILE_SIDE_PX) return ERR_LIMIT;
    return ERR_OK;
}

int message_decode_tile(const void *payload, size_t size_bytes, struct message_tile *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    m->pass.number = bytes_read_u32(&r);
    m->pass.first = bytes_read_u32(&r);
    m->pass.count = bytes_read_u32(&r);
    m->pass.strata = bytes_read_u32(&r);
    m->rect.x0 = read_i32(&r);
    m->rect.y0 = read_i32(&r);
    m->rect.x1 = read_i32(&r);
    m->rect.y1 = read_i32(&r);
    m->counts_bytes = bytes_read_u32(&r);
    if (!r.failed && m->counts_bytes > COUNT_MAP_BYTES_MAX) return ERR_LIMIT;
    m->counts = bytes_borrow(&r, m->counts_bytes);
    int code = bytes_finish(&r);
    if (code == ERR_OK) code = check_index(m->index);
    if (code == ERR_OK) code = check_pass(&m->pass);
    return code != ERR_OK ? code : check_rect(m->rect);
}

/* Counters travel as (number, value) pairs, rising numbers, no zeros: a counter that is added later
 * changes no old bytes. */
static void write_counters(struct bytes_writer *w, const struct counters *counters)
{
    uint16_t count = 0;
    for (unsigned i = 0; i < COUNTER_COUNT; i++)
        if (counters->value[i] != 0) count++;
    bytes_write_u16(w, count);
    for (unsigned i = 0; i < COUNTER_COUNT; i++) {
        if (counters->value[i] == 0) continue;
        bytes_write_u16(w, (uint16_t)i);
        bytes_write_u64(w, counters->value[i]);
    }
}

static int read_counters(struct bytes_reader *r, struct counters *counters)
{
    unsigned count = bytes_read_u16(r), least = 0;
    if (count > COUNTER_COUNT) return ERR_LIMIT;
    for (unsigned i = 0; i < count; i++) {
        unsigned number = bytes_read_u16(r);
        uint64_t value = bytes_read_u64(r);
        if (r->failed) return ERR_TRUNCATED;
        if (number < least || number >= COUNTER_COUNT || value == 0) return ERR_RANGE;
        counters->value[number] = value;
        least = number + 1;
    }
    return r->failed ? ERR_TRUNCATED : ERR_OK;
}

void message_encode_result(struct bytes_writer *w, const struct message_result *m)
{
    write_lease(w, m->frame_id, m->index, m->generation);
    write_counters(w, &m->counters);
}

int message_decode_result(const void *payload, size_t size_bytes, struct message_result *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    int code = read_counters(&r, &m->counters);
    if (code == ERR_OK) code = read_tail(&r, &m->samples, &m->samples_bytes);
    if (code == ERR_OK) code = bytes_finish(&r);
    return code != ERR_OK ? code : check_index(m->index);
}

void message_encode_ack(struct bytes_writer *w, const struct message_ack *m)
{
    write_lease(w, m->frame_id, m->index, m->generation);
    bytes_write_u32(w, m->verdict);
}

int message_decode_ack(const void *payload, size_t size_bytes, struct message_ack *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    m->verdict = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code == ERR_OK) code = check_index(m->index);
    if (code != ERR_OK) return code;
    return m->verdict >= VERDICT_ACCEPTED && m->verdict <= VERDICT_CORRUPT ? ERR_OK : ERR_RANGE;
}

void message_encode_returned(struct bytes_writer *w, const struct message_returned *m)
{
    write_lease(w, m->frame_id, m->index, m->generation);
}

int message_decode_returned(const void *payload, size_t size_bytes, struct message_returned *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    int code = bytes_finish(&r);
    return code != ERR_OK ? code : check_index(m->index);
}

void message_encode_cancel(struct bytes_writer *w, const struct message_cancel *m)
{
    bytes_write_u64(w, m->frame_id);
}

int message_decode_cancel(const void *payload, size_t size_bytes, struct message_cancel *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    m->frame_id = bytes_read_u64(&r);
    return bytes_finish(&r);
}

void message_encode_blob_get(struct bytes_writer *w, const struct message_blob_get *m)
{
    write_digest(w, &m->digest);
    bytes_write_u64(w, m->offset);
    bytes_write_u32(w, m->size_bytes);
}

int message_decode_blob_get(const void *payload, size_t size_bytes, struct message_blob_get *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_digest(&r, &m->digest);
    m->offset = bytes_read_u64(&r);
    m->size_bytes = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    if (m->offset >= LIMIT_BLOB_BYTES || m->size_bytes > LIMIT_BLOB_PART_BYTES) return ERR_LIMIT;
    return m->size_bytes != 0 ? ERR_OK : ERR_RANGE;
}

void message_encode_blob_part(struct bytes_writer *w, const struct message_blob_part *m)
{
    write_digest(w, &m->digest);
    bytes_write_u64(w, m->total_bytes);
    bytes_write_u64(w, m->offset);
}

static int check_blob_part(const struct message_blob_part *m)
{
    if (m->total_bytes > LIMIT_BLOB_BYTES || m->size_bytes > LIMIT_BLOB_PART_BYTES)
        return ERR_LIMIT;
    if (m->size_bytes == 0 || m->offset >= m->total_bytes) return ERR_RANGE;
    return m->size_bytes <= m->total_bytes - m->offset ? ERR_OK : ERR_RANGE;
}

int message_decode_blob_part(const void *payload, size_t size_bytes, struct message_blob_part *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_digest(&r, &m->digest);
    m->total_bytes = bytes_read_u64(&r);
    m->offset = bytes_read_u64(&r);
    int code = read_tail(&r, &m->bytes, &m->size_bytes);
    if (code == ERR_OK) code = bytes_finish(&r);
    return code != ERR_OK ? code : check_blob_part(m);
}

void message_encode_blob_none(struct bytes_writer *w, const struct message_blob_none *m)
{
    write_digest(w, &m->digest);
}

int message_decode_blob_none(const void *payload, size_t size_bytes, struct message_blob_none *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_digest(&r, &m->digest);
    return bytes_finish(&r);
}

void message_encode_beat(struct bytes_writer *w, const struct message_beat *m)
{
    bytes_write_u64(w, m->progress);
    bytes_write_u32(w, m->phase);
    bytes_write_u32(w, m->tiles_in_hand);
    bytes_write_u64(w, m->rss_bytes);
    bytes_write_u64(w, m->peak_rss_bytes);
    bytes_write_u64(w, m->cpu_us);
}

int message_decode_beat(const void *payload, size_t size_bytes, struct message_beat *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    m->progress = bytes_read_u64(&r);
    m->phase = bytes_read_u32(&r);
    m->tiles_in_hand = bytes_read_u32(&r);
    m->rss_bytes = bytes_read_u64(&r);
    m->peak_rss_bytes = bytes_read_u64(&r);
    m->cpu_us = bytes_read_u64(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    if (m->tiles_in_hand > LIMIT_TILES_IN_HAND) return ERR_LIMIT;
    return m->phase <= BEAT_TRACING ? ERR_OK : ERR_RANGE;
}

/* DRAIN and BYE carry a word that must be 0. */
static int decode_reserved(const void *payload, size_t size_bytes, uint32_t *reserved)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    *reserved = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return *reserved == 0 ? ERR_OK : ERR_RANGE;
}

void message_encode_drain(struct bytes_writer *w, const struct message_drain *m)
{
    bytes_write_u32(w, m->reserved);
}

int message_decode_drain(const void *payload, size_t size_bytes, struct message_drain *m)
{
    return decode_reserved(payload, size_bytes, &m->reserved);
}

void message_encode_bye(struct bytes_writer *w, const struct message_bye *m)
{
    bytes_write_u32(w, m->reserved);
}

int message_decode_bye(const void *payload, size_t size_bytes, struct message_bye *m)
{
    return decode_reserved(payload, size_bytes, &m->reserved);
}

void message_encode_tile_fault(struct bytes_writer *w, const struct message_tile_fault *m)
{
    write_lease(w, m->frame_id, m->index, m->generation);
    write_i32(w, m->code);
    write_text(w, m->text, sizeof m->text);
}

int message_decode_tile_fault(const void *payload, size_t size_bytes, struct message_tile_fault *m)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    m->code = read_i32(&r);
    bytes_read_string(&r, m->text, sizeof m->text);
    int code = bytes_finish(&r);
    if (code == ERR_OK) code = check_index(m->index);
    if (code != ERR_OK) return code;
    return m->code < 0 && text_is_clean(m->text) ? ERR_OK : ERR_RANGE;
}
