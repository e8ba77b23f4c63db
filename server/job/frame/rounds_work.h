#pragma once
/* The rounds from inside: for rounds.c and rounds_foresee.c alone. */
#include "proto/limits.h"
#include "server/job/frame/rounds.h"

#define ROUNDS_MAX  32
#define AIM         0.985 /* of the target: estimates that end just above it would take a round more */
#define FIRST_TIMES 5.0    /* the first round: what a tile takes, before anything was seen */
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

/* How far squared errors fell, and samples grew: logarithms. Their quotient is the power of n. */
struct fall {
    double errors, samples;
};

struct rounds_tile {
    struct kind kinds[KINDS];
    uint32_t area;       /* px */
    uint32_t first_pass; /* of this round */
    uint32_t passes;     /* in this round */
    double expected;     /* samples of all its pixels that the target is thought to take in all */
    struct rounds_error seen; /* in this round, as it is drawn, of so many of its pixels */
    uint32_t seen_px;
    bool glanced;         /* it is an estimate */
    double glance[KINDS]; /* squared error of the estimate, as it came; 0: none in this round */
};

struct rounds {
    const struct plan *plan; /* borrowed */
    struct tile_grid grid;
    uint32_t count;
    double pixels;
    struct rounds_report report;
    struct rounds_tile *tiles; /* owned */
    double mean;               /* luminance, after the last round */
    double bias[KINDS];        /* errors over estimates of them, in the last round; 0: not known */
    struct fall falls[KINDS];  /* of the rounds that have ended, the last above all */
    enum foreseen foreseen;    /* which of the powers that are usual is played with */
};

/* The powers of lambda that a kind's scale is to be divided by. */
struct level {
    double lambda, divisor[LAWS];
};

static inline enum law law_of(const struct rounds *r, int kind)
{
    const bool filtered = kind == BOUNCES || r->plan->residual_filter == RESIDUAL_FILTER_HALVES;
    return filtered ? LAW_FILTER : LAW_MEAN;
}

/* Returns the most samples that a pixel may get. */
static inline uint32_t most_of(const struct rounds *r, int kind)
{
    const uint32_t most = r->plan->spp_max;
    return kind == BOUNCES && most > BOUNCES_MAX ? BOUNCES_MAX : most;
}

/* Returns a tile's squared error. Passes with bounce rays trace as many of glossy lobes. */
static inline double variance_of(const struct rounds_error *error, int kind)
{
    return kind == PATHS
               ? error->variance[ERROR_SOURCE_PATHS]
               : error->variance[ERROR_SOURCE_BOUNCES] + error->variance[ERROR_SOURCE_LOBES];
}

/* Sets how much a kind grows where lambda is 1, by its squared error and its samples. */
void rounds_set_scale(const struct rounds *r, struct rounds_tile *t, int kind);

/* Returns the factor by which samples of a kind grow at a level. */
double rounds_growth(const struct rounds *r, const struct kind *k, int kind,
                     const struct level *level);

/* Finds the level at which squared errors add up to `wanted`, or the lowest there is, at which all
 * have the most samples. */
struct level rounds_solve(const struct rounds *r, double wanted);

/* Learns how squared errors fell, and how far estimates were off, when a round is over and its
 * errors are seen. */
void rounds_learn(struct rounds *r);

/* Returns the squared error, over mean luminance, that samples may leave: the target less the part
 * `fixed` that samples do not lower, or a small share of that if it alone exceeds the target. */
double rounds_rest_wanted(const struct rounds *r, double fixed);

/* Gives the tiles of a level their samples. Returns how many passes that takes. */
uint64_t rounds_deal(struct rounds *r, const struct level *level);
