#pragma once
/* Steering of an active job: its priority, whether it is paused, which of its tiles go first. This
 * is the document of PATCH /v1/jobs/{id}. None of it changes a pixel. */
#include "proto/json.h"
#include "proto/tile.h"

/* Members that a document had; bits. */
enum steering_member {
    STEERING_PRIORITY = 1u << 0,
    STEERING_PAUSED = 1u << 1,
    STEERING_REGION = 1u << 2,
    STEERING_NEAR = 1u << 3,
};

struct steering {
    uint32_t given;     /* enum steering_member; the others are zero */
    int32_t priority;   /* -LIMIT_PRIORITY .. LIMIT_PRIORITY */
    bool paused;        /* no new leases; tiles under way may land */
    struct rect region; /* in pixels; empty for null */
    bool has_near;      /* false for null */
    int32_t near_x, near_y;
};

/* Reads {priority, paused, region: {x, y, width, height} | null, near: {x, y} | null}, at least one
 * of them. On failure *fault has the code, the JSON pointer and a sentence. */
int steering_read(const char *text, size_t size_bytes, struct steering *out, struct fault *fault);

/* Returns ERR_RANGE with the member's pointer unless region and point lie within a picture of this
 * size. */
int steering_check(const struct steering *s, int32_t width_px, int32_t height_px,
                   struct fault *fault);
