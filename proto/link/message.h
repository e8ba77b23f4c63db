#pragma once
/* The messages of a worker link: one struct, one encode and one decode each. Prose: PROTOCOL.md.
 *
 * Decoders check every field against limits.h and leave no pointer outside the payload. Structs
 * borrow byte ranges from the payload that they were decoded from. */
#include "proto/bytes.h"
#include "proto/counter.h"
#include "proto/digest.h"
#include "proto/error.h"
#include "proto/log/trace_context.h"
#include "proto/plan.h"
#include "proto/tile.h"

#define PROTOCOL_VERSION 24u

enum message_type {
#define MESSAGE(name, number, type, sender, text) MESSAGE_##name = (number),
#include "proto/link/message.def"
#undef MESSAGE
};

struct message_hello {
    uint32_t protocol_version;
    uint32_t capabilities;
    char build_id[LIMIT_NAME_BYTES]; /* must equal the coordinator's */
    char embree_version[LIMIT_NAME_BYTES];
    char isa[LIMIT_NAME_BYTES];  /* "avx512", "avx2", "sse4.2": Embree's and the kernels' */
    char name[LIMIT_NAME_BYTES]; /* is shown to users: host:pid */
    uint32_t threads;
    uint64_t pid;
};

/* The bits of a worker id from here on number the runs of the coordinator. After a reconnect to
 * another run a worker drops its leases, since frame ids are numbered anew. */
#define WORKER_ID_LIFE_SHIFT 28

struct message_welcome {
    uint64_t worker_id; /* below 2^52 */
    uint32_t beat_ms;   /* send BEAT this often */
};

struct message_refused {
    int32_t code; /* ERR_VERSION, ERR_MISMATCH, ... */
    char text[LIMIT_DETAIL_BYTES];
};

struct message_want {
    uint32_t tiles; /* more than the worker holds or has already asked for */
};

struct message_frame_plan {
    uint64_t frame_id;                    /* unique in a run of the coordinator */
    char job[LIMIT_JOB_ID_BYTES];         /* for the worker's log; "": unknown */
    char trace[TRACE_CONTEXT_TEXT_BYTES]; /* of the request that submitted it (trace_context_keep),
                                             or "" */
    const uint8_t *plan;                  /* plan_decode reads it; borrowed */
    uint32_t plan_bytes;
};

struct message_tile {
    uint64_t frame_id;
    uint32_t index;
    uint32_t generation;
    struct plan_pass pass; /* first, count and strata all 0: the schedule's (plan.h); its strata
                              maps travel as `counts` */
    struct rect rect;
    const uint8_t *counts; /* count_map.h of the pass's strata maps; borrowed */
    uint32_t counts_bytes; /* 0: the pass has none */
};

struct message_result {
    uint64_t frame_id;
    uint32_t index;
    uint32_t generation;
    struct counters counters;
    const uint8_t *samples; /* samples_unpack reads it; borrowed; to the payload's end */
    uint32_t samples_bytes;
};

enum verdict {
    VERDICT_ACCEPTED = 1,
    VERDICT_DUPLICATE = 2, /* another copy came first */
    VERDICT_STALE = 3,     /* the lease has passed to another generation */
    VERDICT_FOREIGN = 4,   /* the frame is gone, or the tile was never leased to this session */
    VERDICT_CORRUPT = 5,   /* the samples do not fit the plan */
};

struct message_ack {
    uint64_t frame_id;
    uint32_t index;
    uint32_t generation;
    uint32_t verdict;
};

struct message_returned {
    uint64_t frame_id;
    uint32_t index;
    uint32_t generation;
};

struct message_cancel {
    uint64_t frame_id;
};

struct message_blob_get {
    struct digest digest;
    uint64_t offset;
    uint32_t size_bytes; /* at most LIMIT_BLOB_PART_BYTES */
};

struct message_blob_part {
    struct digest digest;
    uint64_t total_bytes;
    uint64_t offset;
    const uint8_t *bytes; /* borrowed; to the payload's end */
    uint32_t size_bytes;
};

struct message_blob_none {
    struct digest digest;
};

enum beat_phase { BEAT_IDLE = 0, BEAT_LOADING = 1, BEAT_TRACING = 2 };

struct message_beat {
    uint64_t progress; /* counts rows traced and blob parts loaded; grows while work goes on */
    uint32_t phase;
    uint32_t tiles_in_hand;
    uint64_t rss_bytes;
    uint64_t peak_rss_bytes;
    uint64_t cpu_us; /* of the whole process since its start */
};

struct message_drain {
    uint32_t reserved;
};

struct message_bye {
    uint32_t reserved;
};

struct message_tile_fault {
    uint64_t frame_id;
    uint32_t index;
    uint32_t generation;
    int32_t code;
    char text[LIMIT_DETAIL_BYTES];
};

/* Returns the name of a message: "HELLO" for 1, NULL for an unknown number. */
const char *message_name(uint16_t type);

/* Returns whether a text is printable UTF-8. No other text travels, since it reaches logs,
 * terminals and JSON. */
bool message_text_is_clean(const char *text);

/* One pair a message: encode appends the payload (without the frame header) to w, whose `failed`
 * tells of exhausted memory; decode reads a payload, returns 0 or ERR_TRUNCATED, ERR_TRAILING,
 * ERR_LIMIT, ERR_RANGE. For RESULT and BLOB_PART encode writes all but the trailing byte range,
 * which goes out as the frame's tail. A HELLO of another protocol version yields ERR_VERSION and
 * that version, all else zero, whatever follows it: so it can be refused with words. Texts that are
 * not printable UTF-8 are ERR_RANGE to a decoder and cleaned by an encoder. */
#define MESSAGE(name, number, type, sender, text)                                                  \
    void message_encode_##type(struct bytes_writer *w, const struct message_##type *m);            \
    int message_decode_##type(const void *payload, size_t size_bytes, struct message_##type *m);
#include "proto/link/message.def"
#undef MESSAGE
