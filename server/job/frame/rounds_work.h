#pragma once
/* The rounds from inside: for rounds.c and rounds_forecast.c alone. */
#include "proto/limits.h"
#include "server/job/frame/rounds.h"

#define BOUNCES_MAX 16384u /* means travel as half floats: beyond, rounding is what is left */

/* What one tile has of one kind of samples, a pixel. */
struct kind {
    double variance; /* summed over pixels; 0 where there are none of the kind */
    double scale;    /* factor of growth where lambda is 1 */
    uint32_t n;      /* of the rounds that have ended */
    uint32_t more;   /* in this round */
};

enum { PATHS, BOUNCES, KINDS };

/* How squared errors fall with the number of samples. */
enum law {
    LAW_MEAN,   /* as 1 / n */
    LAW_FILTER, /* as n^(-2/3): a filter gets narrower meanwhile */
    LAWS
};

struct rounds_tile {
    struct kind kinds[KINDS];
    uint32_t area;       /* px */
    uint32_t first_pass; /* of this round */
    uint32_t passes;     /* in this round */
    double expected;     /* samples of all its pixels that the target is thought to take in all */
};

struct rounds {
    const struct plan *plan; /* borrowed */
    struct tile_grid grid;
    uint32_t count;
    double pixels;
    struct rounds_report report;
    struct rounds_tile *tiles; /* owned */
};

static inline enum law law_of(const struct rounds *r, int kind)
{
    const bool filtered = kind == BOUNCES || r->plan->residual_filter != RESIDUAL_FILTER_NONE;
    return filtered ? LAW_FILTER : LAW_MEAN;
}

/* Returns the most samples that a pixel may get. */
static inline uint32_t most_of(const struct rounds *r, int kind)
{
    const uint32_t most = r->plan->spp_max;
    return kind == BOUNCES && most > BOUNCES_MAX ? BOUNCES_MAX : most;
}

/* Foresees the samples of each tile, and of all, once a round was dealt. `wanted`: squared errors
 * that samples may leave, summed over pixels. */
void rounds_forecast(struct rounds *r, double wanted);
