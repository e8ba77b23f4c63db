#pragma once
/* A worker that misbehaves by script: what it was told, what it knows and what it has counted. */
#include <stdbool.h>
#include <stdint.h>
#include <time.h>

#include "proto/link/message.h"
#include "proto/link/wire_frame.h"
#include "proto/plan.h"

#define FAKE_FRAMES 64u

struct fake;

struct script {
    const char *name;
    const char *text;
    void (*tile)(struct fake *f, uint64_t request_id, const struct message_tile *tile);
    bool no_beats;
};

struct known_frame {
    uint64_t id;
    struct plan plan;
};

struct fake {
    const struct script *script;
    const char *address, *embree, *name;
    uint32_t threads;
    double seconds;
    uint64_t tiles_max, reconnects;
    int fd; /* -1: there is no link */
    bool refused;
    struct wire_frame_inbox inbox;
    struct known_frame *frames; /* the last FAKE_FRAMES */
    uint64_t frame_count;
    struct bytes_writer packed; /* the last zero samples, of these: */
    uint64_t packed_frame;
    uint32_t packed_pass;
    int32_t packed_width, packed_height;
    uint64_t tiles, answers, acks[VERDICT_CORRUPT + 1];
    uint64_t started_ms, beat_ms, next_beat_ms, next_request;
};

static inline uint64_t fake_now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000u + (uint64_t)t.tv_nsec / 1000000u;
}

static inline bool fake_is_over(const struct fake *f)
{
    return f->refused || (f->tiles_max > 0 && f->answers >= f->tiles_max) ||
           (double)(fake_now_ms() - f->started_ms) >= 1000.0 * f->seconds;
}
