/* Names of messages, and those of the session as a whole. */
#include "proto/link/message.h"

#include "proto/link/message_parts.h"

/* Encoders write what decoders accept: texts are cleaned on the way out and refused unclean on the
 * way in. Decoders zero the struct first, read all fields, ask once whether the payload had exactly
 * the right size, then check the values. */

const char *message_name(uint16_t type)
{
    switch (type) {
#define MESSAGE(name, number, type, sender, text)                                                  \
    case number:                                                                                   \
        return #name;
#include "proto/link/message.def"
#undef MESSAGE
    default:
        return NULL;
    }
}

void message_encode_hello(struct bytes_writer *w, const struct message_hello *m)
{
    bytes_write_u32(w, m->protocol_version);
    bytes_write_u32(w, m->capabilities);
    message_write_text(w, m->build_id, sizeof m->build_id);
    message_write_text(w, m->embree_version, sizeof m->embree_version);
    message_write_text(w, m->isa, sizeof m->isa);
    message_write_text(w, m->name, sizeof m->name);
    bytes_write_u32(w, m->threads);
    bytes_write_u64(w, m->pid);
}

/* Tells a name that is too long from a HELLO that was cut. */
static bool text_is_too_long(struct bytes_reader at, size_t capacity)
{
    return bytes_read_u16(&at) >= capacity;
}

static int check_hello(const struct message_hello *m)
{
    if (m->threads > LIMIT_THREADS) return ERR_LIMIT;
    if (m->threads == 0) return ERR_RANGE;
    if (!message_text_is_clean(m->build_id) || !message_text_is_clean(m->embree_version))
        return ERR_RANGE;
    if (!message_text_is_clean(m->isa) || !message_text_is_clean(m->name)) return ERR_RANGE;
    return ERR_OK;
}

int message_decode_hello(const void *payload, size_t size_bytes, struct message_hello *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    m->protocol_version = bytes_read_u32(&r);
    /* Of another version's HELLO only the number is sure, and it is all that a refusal needs. */
    if (!r.failed && m->protocol_version != PROTOCOL_VERSION) return ERR_VERSION;
    m->capabilities = bytes_read_u32(&r);
    bytes_read_string(&r, m->build_id, sizeof m->build_id);
    bytes_read_string(&r, m->embree_version, sizeof m->embree_version);
    bytes_read_string(&r, m->isa, sizeof m->isa);
    if (text_is_too_long(r, sizeof m->name)) return ERR_LIMIT;
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
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    m->worker_id = bytes_read_u64(&r);
    m->beat_ms = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return m->beat_ms != 0 ? ERR_OK : ERR_RANGE;
}

void message_encode_refused(struct bytes_writer *w, const struct message_refused *m)
{
    message_write_i32(w, m->code);
    message_write_text(w, m->text, sizeof m->text);
}

int message_decode_refused(const void *payload, size_t size_bytes, struct message_refused *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    m->code = message_read_i32(&r);
    bytes_read_string(&r, m->text, sizeof m->text);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return m->code < 0 && message_text_is_clean(m->text) ? ERR_OK : ERR_RANGE;
}

void message_encode_want(struct bytes_writer *w, const struct message_want *m)
{
    bytes_write_u32(w, m->tiles);
}

int message_decode_want(const void *payload, size_t size_bytes, struct message_want *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    m->tiles = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    return m->tiles <= LIMIT_TILES_IN_HAND ? ERR_OK : ERR_LIMIT;
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
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
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
