#pragma once
/* A scene of formulas for the filters of indirect light: a room open to the camera with a chequered
 * floor and coloured walls, two turned boxes, two spheres and a lamp without size; one bounce of
 * diffuse light, traced here in the manner of the worker: the pixel's centre, l x l cosine strata
 * by the pattern around Frisvad's frame, distances as half floats. */
#include <stdint.h>

#include "proto/half.h"
#include "proto/samples.h"
#include "server/reconstruct/patch/patch.h"

#define ROOM_BOXES 2
#define ROOM_FAR   1e30f
#define ROOM_OFF   1e-4f /* rays start that far off surfaces */

struct room_hit {
    float t; /* ROOM_FAR: nothing */
    float point[3], normal[3], albedo[3];
    uint32_t id; /* 1: the room; then boxes and spheres */
};

/* Unit d. */
struct room_hit room_trace(const float o[3], const float d[3]);

/* Light of the lamp that the surface sends on. */
void room_shade(const struct room_hit *h, float radiance[3]);

/* Shirley and Chiu's disk, raised onto the hemisphere. */
void room_direction(const float at[2], float out[3]);

/* What a pixel's centre sees. */
struct room_hit room_primary(const struct plan *plan, int32_t x, int32_t y);

/* The whole room, `lines` high and as wide. */
void room_plan(struct plan *plan, int32_t lines, uint32_t filter, uint32_t strata);

/* The samples of `rect`. Owned by the caller. */
struct patch *room_patch(const struct plan *plan, struct rect rect);

/* Converged light of a pixel: `side` x `side` strata, each with its own jitter. */
void room_truth(const struct plan *plan, int32_t x, int32_t y, uint32_t side, double out[3]);
