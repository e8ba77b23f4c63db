/* Messages about frames and their tiles. */
#include "proto/count_map.h"
#include "proto/link/message.h"
#include "proto/link/message_parts.h"

/* Largest index of a tile plus one: the finest grid over the largest image. */
#define TILE_INDEX_END                                                                             \
    ((LIMIT_IMAGE_SIDE_PX / LIMIT_TILE_SIDE_MIN_PX) *                                              \
     (LIMIT_IMAGE_SIDE_PX / LIMIT_TILE_SIDE_MIN_PX))

/* Writes frame, index and generation, which name a lease. */
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

void message_encode_frame_plan(struct bytes_writer *w, const struct message_frame_plan *m)
{
    bytes_write_u64(w, m->frame_id);
    message_write_text(w, m->job, sizeof m->job);
    message_write_text(w, m->trace, sizeof m->trace);
    bytes_write_u32(w, m->plan_bytes);
    bytes_write_raw(w, m->plan, m->plan_bytes);
}

int message_decode_frame_plan(const void *payload, size_t size_bytes, struct message_frame_plan *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    m->frame_id = bytes_read_u64(&r);
    bytes_read_string(&r, m->job, sizeof m->job);
    bytes_read_string(&r, m->trace, sizeof m->trace);
    m->plan_bytes = bytes_read_u32(&r);
    if (!r.failed && m->plan_bytes > LIMIT_FRAME_BYTES) return ERR_LIMIT;
    m->plan = bytes_borrow(&r, m->plan_bytes);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return message_text_is_clean(m->job) && message_text_is_clean(m->trace) ? ERR_OK : ERR_RANGE;
}

void message_encode_tile(struct bytes_writer *w, const struct message_tile *m)
{
    write_lease(w, m->frame_id, m->index, m->generation);
    bytes_write_u32(w, m->pass.number);
    bytes_write_u32(w, m->pass.first);
    bytes_write_u32(w, m->pass.count);
    bytes_write_u32(w, m->pass.strata);
    message_write_i32(w, m->rect.x0);
    message_write_i32(w, m->rect.y0);
    message_write_i32(w, m->rect.x1);
    message_write_i32(w, m->rect.y1);
    bytes_write_u32(w, m->counts_bytes);
    bytes_write_raw(w, m->counts, m->counts_bytes);
}

static int check_pass(const struct plan_pass *pass)
{
    if (pass->number >= LIMIT_PASSES || pass->first > LIMIT_SPP) return ERR_LIMIT;
    return pass->count > LIMIT_PASS_LENS_SAMPLES || pass->strata > LIMIT_STRATA_PER_AXIS ? ERR_LIMIT
                                                                                         : 0;
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
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    m->pass.number = bytes_read_u32(&r);
    m->pass.first = bytes_read_u32(&r);
    m->pass.count = bytes_read_u32(&r);
    m->pass.strata = bytes_read_u32(&r);
    m->rect.x0 = message_read_i32(&r);
    m->rect.y0 = message_read_i32(&r);
    m->rect.x1 = message_read_i32(&r);
    m->rect.y1 = message_read_i32(&r);
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
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    int code = read_counters(&r, &m->counters);
    if (code == ERR_OK) code = message_read_tail(&r, &m->samples, &m->samples_bytes);
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
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
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
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
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
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    m->frame_id = bytes_read_u64(&r);
    return bytes_finish(&r);
}

void message_encode_tile_fault(struct bytes_writer *w, const struct message_tile_fault *m)
{
    write_lease(w, m->frame_id, m->index, m->generation);
    message_write_i32(w, m->code);
    message_write_text(w, m->text, sizeof m->text);
}

int message_decode_tile_fault(const void *payload, size_t size_bytes, struct message_tile_fault *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    read_lease(&r, &m->frame_id, &m->index, &m->generation);
    m->code = message_read_i32(&r);
    bytes_read_string(&r, m->text, sizeof m->text);
    int code = bytes_finish(&r);
    if (code == ERR_OK) code = check_index(m->index);
    if (code != ERR_OK) return code;
    return m->code < 0 && message_text_is_clean(m->text) ? ERR_OK : ERR_RANGE;
}
