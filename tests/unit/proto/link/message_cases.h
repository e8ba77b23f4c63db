#pragma once
/* One filled-in struct of each message, and each message's functions in a table: what the message
 * tests and the golden bytes are made from. Changing a value here changes golden bytes. */
#include <string.h>

#include "proto/link/message.h"

static const uint8_t case_bytes[] = {0x00, 0x01, 0xfe, 0xff, 0x10, 0x20, 0x30};

static inline struct digest case_digest(void)
{
    struct digest d;
    for (size_t i = 0; i < DIGEST_BYTES; i++) d.bytes[i] = (uint8_t)(0xa0 + i);
    return d;
}

static inline void case_hello(struct message_hello *m)
{
    m->protocol_version = PROTOCOL_VERSION;
    m->capabilities = CAPABILITY_DIRECT | CAPABILITY_STRATA;
    strcpy(m->build_id, "0.1.0+3f9c01d2a4b5");
    strcpy(m->embree_version, "3.13.5");
    strcpy(m->isa, "avx2");
    strcpy(m->name, "render\xc3\xa9-7:4711");
    m->threads = 12;
    m->pid = 4711;
}

static inline void case_welcome(struct message_welcome *m)
{
    m->worker_id = 0x1122334455667788ull;
    m->beat_ms = 500;
}

static inline void case_refused(struct message_refused *m)
{
    m->code = ERR_MISMATCH;
    strcpy(m->text, "another build: install 0.1.0 on this machine");
}

static inline void case_want(struct message_want *m)
{
    m->tiles = 3;
}

static inline void case_frame_plan(struct message_frame_plan *m)
{
    m->frame_id = 77;
    strcpy(m->job, "01m81bqv6g023bzgj1ehn7c5m6");
    strcpy(m->trace, "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01");
    m->plan = case_bytes;
    m->plan_bytes = sizeof case_bytes;
}

static inline void case_tile(struct message_tile *m)
{
    m->frame_id = 77;
    m->index = 2097151;
    m->generation = 4;
    m->pass = (struct plan_pass){259, 70000 - 7000, 52, 6, NULL, NULL};
    m->rect = (struct rect){16320, 8128, 16384, 8192};
    m->counts = case_bytes;
    m->counts_bytes = sizeof case_bytes;
}

static inline void case_result(struct message_result *m)
{
    m->frame_id = 77;
    m->index = 5;
    m->generation = 0xfffffffeu;
    m->counters.value[COUNTER_RAYS_PRIMARY] = 4096;
    m->counters.value[COUNTER_RAYS_SHADOW] = 36864;
    m->counters.value[COUNTER_BUILD_CPU_US] = UINT64_MAX;
    m->samples = case_bytes;
    m->samples_bytes = sizeof case_bytes;
}

static inline void case_ack(struct message_ack *m)
{
    m->frame_id = 77;
    m->index = 5;
    m->generation = 4;
    m->verdict = VERDICT_STALE;
}

static inline void case_returned(struct message_returned *m)
{
    m->frame_id = 77;
    m->index = 6;
    m->generation = 1;
}

static inline void case_cancel(struct message_cancel *m)
{
    m->frame_id = 0x0102030405060708ull;
}

static inline void case_blob_get(struct message_blob_get *m)
{
    m->digest = case_digest();
    m->offset = 3 * (uint64_t)LIMIT_BLOB_PART_BYTES;
    m->size_bytes = LIMIT_BLOB_PART_BYTES;
}

static inline void case_blob_part(struct message_blob_part *m)
{
    m->digest = case_digest();
    m->total_bytes = 5000000000ull;
    m->offset = m->total_bytes - sizeof case_bytes;
    m->bytes = case_bytes;
    m->size_bytes = sizeof case_bytes;
}

static inline void case_blob_none(struct message_blob_none *m)
{
    m->digest = case_digest();
}

static inline void case_beat(struct message_beat *m)
{
    m->progress = 123456789012ull;
    m->phase = BEAT_TRACING;
    m->tiles_in_hand = 2;
    m->rss_bytes = 300000000;
    m->peak_rss_bytes = 400000000;
    m->cpu_us = 98765432;
}

static inline void case_drain(struct message_drain *m)
{
    m->reserved = 0;
}

static inline void case_bye(struct message_bye *m)
{
    m->reserved = 0;
}

static inline void case_tile_fault(struct message_tile_fault *m)
{
    m->frame_id = 77;
    m->index = 9;
    m->generation = 2;
    m->code = ERR_CORRUPT;
    strcpy(m->text, "scene blob: meshes[3].material: 9 is above 4");
}

/* Byte ranges that a struct borrows are compared by content; the rest of the struct as it lies:
 * decoders zero it first, as do the cases. */
static inline void no_range(void *m, const uint8_t **bytes, uint32_t *size_bytes)
{
    (void)m;
    *bytes = NULL;
    *size_bytes = 0;
}

#define RANGE_OF(type, pointer, size)                                                              \
    static inline void range_of_##type(void *m, const uint8_t **bytes, uint32_t *size_bytes)       \
    {                                                                                              \
        struct message_##type *message = m;                                                        \
        *bytes = message->pointer;                                                                 \
        *size_bytes = message->size;                                                               \
        message->pointer = NULL;                                                                   \
    }
RANGE_OF(frame_plan, plan, plan_bytes)
RANGE_OF(tile, counts, counts_bytes)
RANGE_OF(result, samples, samples_bytes)
RANGE_OF(blob_part, bytes, size_bytes)
#undef RANGE_OF

struct message_case {
    const char *name;
    uint16_t number;
    size_t struct_bytes;
    void (*fill)(void *m);
    void (*encode)(struct bytes_writer *w, const void *m);
    int (*decode)(const void *payload, size_t size_bytes, void *m);
    /* Takes the borrowed range out of the struct: nulls the pointer. */
    void (*range)(void *m, const uint8_t **bytes, uint32_t *size_bytes);
    bool has_tail; /* the range goes out behind what encode wrote */
};

#define MESSAGE(name, number, type, sender, text)                                                  \
    static inline void fill_##type(void *m)                                                        \
    {                                                                                              \
        memset(m, 0, sizeof(struct message_##type));                                               \
        case_##type(m);                                                                            \
    }                                                                                              \
    static inline void encode_##type(struct bytes_writer *w, const void *m)                        \
    {                                                                                              \
        message_encode_##type(w, m);                                                               \
    }                                                                                              \
    static inline int decode_##type(const void *payload, size_t size_bytes, void *m)               \
    {                                                                                              \
        return message_decode_##type(payload, size_bytes, m);                                      \
    }
#include "proto/link/message.def"
#undef MESSAGE

#define RANGE_hello      no_range
#define RANGE_welcome    no_range
#define RANGE_refused    no_range
#define RANGE_want       no_range
#define RANGE_frame_plan range_of_frame_plan
#define RANGE_tile       range_of_tile
#define RANGE_result     range_of_result
#define RANGE_ack        no_range
#define RANGE_returned   no_range
#define RANGE_cancel     no_range
#define RANGE_blob_get   no_range
#define RANGE_blob_part  range_of_blob_part
#define RANGE_blob_none  no_range
#define RANGE_beat       no_range
#define RANGE_drain      no_range
#define RANGE_bye        no_range
#define RANGE_tile_fault no_range

static const struct message_case message_cases[] = {
#define MESSAGE(name, number, type, sender, text)                                                  \
    {#name,                                                                                        \
     number,                                                                                       \
     sizeof(struct message_##type),                                                                \
     fill_##type,                                                                                  \
     encode_##type,                                                                                \
     decode_##type,                                                                                \
     RANGE_##type,                                                                                 \
     (number) == MESSAGE_RESULT || (number) == MESSAGE_BLOB_PART},
#include "proto/link/message.def"
#undef MESSAGE
};
#define MESSAGE_CASES (sizeof message_cases / sizeof *message_cases)

/* Any message. */
union message_any {
#define MESSAGE(name, number, type, sender, text) struct message_##type type;
#include "proto/link/message.def"
#undef MESSAGE
};

/* The whole payload, tail included. */
static inline void case_payload(const struct message_case *c, const union message_any *m,
                                struct bytes_writer *w)
{
    union message_any copy = *m;
    const uint8_t *bytes;
    uint32_t size_bytes;
    c->encode(w, m);
    c->range(&copy, &bytes, &size_bytes);
    if (c->has_tail) bytes_write_raw(w, bytes, size_bytes);
}
