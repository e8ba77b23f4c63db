/* How many samples a target will take in the end, for the time left. No picture depends on it.
 *
 * The rounds that are to come are played to their end: each deals samples as a true round does
 * (rounds.h), and errors then fall with a power of n. Plain means of paths have one of their own.
 * Under a filter it was 0.5 to 1.1 in eight scenes, and a scene keeps its own: from rounds that
 * have ended it is learnt, but not from the errors of a few samples, which say nothing of it. Tiles
 * that seem to have most of the error are not left out, since they mostly have it.
 *
 * What has been drawn in this round is taken as it is. The rest of the picture is taken to be like
 * it: in the first round altogether, where glances tell more of it than blocks that were drawn,
 * later in how its errors fall short of what was foreseen.
 *
 * All is played three times: with the power that is likely, and with the greatest and the least
 * that was seen, for the least and the most samples. What a round shows outweighs both, so that
 * they come together; by then the likely ones are right, which they seldom are before. */
#include <math.h>
#include <stdlib.h>

#include "server/job/frame/rounds_work.h"

#define LEARNT_FROM  8.0  /* samples a pixel: errors of fewer say nothing of the power */
#define LEARNT_AFTER 0.6  /* growth, a logarithm, at which what is learnt outweighs the usual */
#define FORGOTTEN    0.5  /* of what was learnt, with each round */
#define SEEN_FEW     4.0  /* tiles, which count half beside what had been foreseen */
#define SEEN_TRUST   4.0  /* a quarter of the picture tells of the rest */
#define UNSEEN       6.0  /* times more or less than the first round's first tiles tell */
#define PLAYED_MAX   256u /* tiles; of more, each plays for those behind it */

/* The power of plain means, whose tiles are chosen by errors that chance has raised or lowered, and
 * of filtered ones before any is learnt: errors that fall fast take the least samples. */
static const double power_mean[FORESEEN_COUNT] = {0.95, 1.0, 0.9};
static const double power_filter[FORESEEN_COUNT] = {0.75, 1.1, 0.5};

static void forget(struct rounds_tile *t)
{
    t->seen = (struct rounds_error){0};
    t->seen_px = 0;
    t->glanced = false;
}

void rounds_see(struct rounds *r, uint32_t tile, const struct rounds_error *part, uint32_t pixels)
{
    struct rounds_tile *t = &r->tiles[tile];
    if (t->glanced) forget(t);
    for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++) t->seen.variance[k] += part->variance[k];
    t->seen.luminance += part->luminance;
    t->seen_px += pixels;
}

/* Few pixels around a tile make its error greater, which the round before tells. */
void rounds_glance(struct rounds *r, uint32_t tile, const struct rounds_error *error)
{
    struct rounds_tile *t = &r->tiles[tile];
    if (t->seen_px > 0) return;
    t->seen = *error;
    t->seen_px = t->area;
    t->glanced = true;
    for (int kind = 0; kind < KINDS; kind++) t->glance[kind] = variance_of(error, kind);
    for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++) {
        const double bias = r->bias[k == ERROR_SOURCE_PATHS ? PATHS : BOUNCES];
        if (bias > 0.0) t->seen.variance[k] *= bias;
    }
}

static bool is_seen(const struct rounds_tile *t)
{
    return t->seen_px >= t->area;
}

static double samples_of(const struct rounds_tile *t)
{
    return (double)t->kinds[PATHS].n + t->kinds[PATHS].more + t->kinds[BOUNCES].n +
           t->kinds[BOUNCES].more;
}

/* -- how errors fall -- */

static double power_of(const struct rounds *r, int kind)
{
    const struct fall *fall = &r->falls[kind];
    if (law_of(r, kind) == LAW_MEAN) return power_mean[r->foreseen];
    return (power_filter[r->foreseen] * LEARNT_AFTER + fall->errors) /
           (LEARNT_AFTER + fall->samples);
}

/* Returns what is left of a kind's squared error once its tile has this round's samples. */
static double left_of(const struct kind *k, double power)
{
    return k->n > 0 ? k->variance * pow((double)k->n / ((double)k->n + k->more), power) : 0.0;
}

/* What a round has shown of a kind's squared errors so far: of tiles that get samples, sums. */
struct shown {
    double tiles, before, after, from; /* `from`: before, times samples a pixel */
    double as_mean, as_foreseen;       /* what would be left */
};

static struct shown shown_of(const struct rounds *r, int kind)
{
    struct shown sum = {.tiles = 0.0};
    for (uint32_t i = 0; i < r->count; i++) {
        const struct rounds_tile *t = &r->tiles[i];
        const struct kind *k = &t->kinds[kind];
        if (k->n == 0 || k->more == 0 || !is_seen(t)) continue;
        sum.tiles += 1.0;
        sum.before += k->variance;
        sum.from += k->variance * k->n;
        sum.after += variance_of(&t->seen, kind);
        sum.as_mean += left_of(k, 1.0);
        sum.as_foreseen += left_of(k, power_of(r, kind));
    }
    return sum;
}

static double trust_of(const struct shown *shown)
{
    return shown->tiles / (shown->tiles + SEEN_FEW);
}

/* Adds how a kind's errors have fallen in this round, where they are seen. */
static void add_fall(struct rounds *r, int kind)
{
    const struct shown shown = shown_of(r, kind);
    if (!(shown.after > 0.0 && shown.as_mean > 0.0 && shown.from >= LEARNT_FROM * shown.before))
        return;
    r->falls[kind].errors += trust_of(&shown) * log(shown.before / shown.after);
    r->falls[kind].samples += trust_of(&shown) * log(shown.before / shown.as_mean);
}

/* Returns what was seen of a kind's errors over what had been foreseen of them. */
static double surprise_of(const struct rounds *r, int kind)
{
    const struct shown shown = shown_of(r, kind);
    if (!(shown.after > 0.0 && shown.as_foreseen > 0.0)) return 1.0;
    return pow(shown.after / shown.as_foreseen, trust_of(&shown));
}

/* Of the first round's, which had no pixels around them, nothing is learnt. */
static void learn_bias(struct rounds *r, int kind)
{
    double glances = 0.0, errors = 0.0;
    for (uint32_t i = 0; i < r->count; i++) {
        const struct rounds_tile *t = &r->tiles[i];
        if (t->glance[kind] > 0.0) errors += variance_of(&t->seen, kind);
        glances += t->glance[kind];
    }
    if (r->report.rounds > 1 && glances > 0.0 && errors > 0.0) r->bias[kind] = errors / glances;
}

void rounds_learn(struct rounds *r)
{
    for (int kind = 0; kind < KINDS; kind++) learn_bias(r, kind);
    for (int kind = 0; kind < KINDS; kind++) {
        add_fall(r, kind);
        r->falls[kind].errors *= FORGOTTEN;
        r->falls[kind].samples *= FORGOTTEN;
    }
}

/* -- what is to come -- */

static void take(struct kind *k, double variance)
{
    k->n += k->more;
    k->more = 0;
    k->variance = variance;
}

/* Ends a tile's round: it has its samples, and what was seen of its errors, or what is left of them
 * times `by`. */
static void end_tile(const struct rounds *r, struct rounds_tile *t, const double by[KINDS])
{
    t->first_pass += t->passes;
    t->passes = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        struct kind *k = &t->kinds[kind];
        const double left = left_of(k, power_of(r, kind)) * by[kind];
        take(k, is_seen(t) ? variance_of(&t->seen, kind) : left);
        rounds_set_scale(r, t, kind);
    }
    t->seen_px = 0;
}

static double squares_of(const struct rounds_tile *t)
{
    return t->kinds[PATHS].variance + t->kinds[BOUNCES].variance;
}

static double squares(const struct rounds *r)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < r->count; i++) sum += squares_of(&r->tiles[i]);
    return sum;
}

static void play(struct rounds *r, double wanted)
{
    static const double as_usual[KINDS] = {1.0, 1.0};
    for (uint32_t k = r->report.rounds + 1; k <= ROUNDS_MAX; k++) {
        if (squares(r) <= wanted / (AIM * AIM)) break;
        const struct level level = rounds_solve(r, wanted);
        if (rounds_deal(r, &level) == 0) break;
        for (uint32_t i = 0; i < r->count; i++) end_tile(r, &r->tiles[i], as_usual);
    }
}

/* What is known of the picture when a round is not over. */
struct known {
    uint32_t *tiles; /* owned; of each tile one with a known error: itself, or what it is like */
    uint32_t count;  /* of tiles; 0: nothing is known */
    double share;    /* of the picture that was seen */
    double pixels, luminance, fixed; /* of these tiles */
};

/* Lets tiles that were not seen be like those that were glanced at, in turn: these lie all over the
 * picture, while blocks are drawn from the top and tell of what is there. Without a glance any will
 * do. */
static void spread(const struct rounds *r, struct known *known, uint32_t *like)
{
    uint32_t seen = 0, glanced = 0, next = 0;
    for (uint32_t i = 0; i < r->count; i++) glanced += r->tiles[i].glanced;
    for (uint32_t i = 0; i < r->count; i++)
        if (is_seen(&r->tiles[i]) && (glanced == 0 || r->tiles[i].glanced)) like[seen++] = i;
    for (uint32_t i = 0; i < r->count && seen > 0; i++)
        known->tiles[i] = is_seen(&r->tiles[i]) ? i : like[next++ % seen];
    known->count = seen > 0 ? r->count : 0;
}

static void find_known(const struct rounds *r, struct known *out, uint32_t *like)
{
    double seen_px = 0.0;
    if (r->report.rounds == 0) {
        spread(r, out, like);
    } else {
        for (uint32_t i = 0; i < r->count; i++) out->tiles[i] = i;
        out->count = r->count;
    }
    for (uint32_t i = 0; i < out->count; i++) {
        const struct rounds_tile *t = &r->tiles[out->tiles[i]];
        out->pixels += t->area;
        out->luminance += t->seen.luminance;
        out->fixed += t->seen.variance[ERROR_SOURCE_CENTRES];
        seen_px += is_seen(&r->tiles[i]) ? r->tiles[i].area : 0.0;
    }
    out->share = seen_px / r->pixels;
}

/* Returns what samples may leave of the squared errors of the known tiles. */
static double wanted_of(const struct rounds *r, const struct known *known)
{
    double mean = r->mean, fixed = r->report.fixed;
    if (r->report.rounds == 0) {
        mean = known->luminance / known->pixels;
        fixed = mean > 0.0 ? sqrt(known->fixed / known->pixels) / mean : 0.0;
    }
    return rounds_rest_wanted(r, fixed) * mean * mean * known->pixels;
}

/* Returns the known tile that plays for those of its group. Tiles at even steps would be of few
 * columns. */
static uint32_t player_of(const struct known *known, uint32_t group, uint32_t step)
{
    const uint32_t k = group * step + (group * UINT32_C(2654435769) >> 16) % step;
    return known->tiles[k < known->count ? k : group * step];
}

/* Returns the samples that a known tile takes: as many a pixel more as the one that played for it.
 */
static double told_of(const struct rounds *r, const struct known *known,
                      const struct rounds *played, uint32_t i, uint32_t step)
{
    const struct rounds_tile *t = &r->tiles[known->tiles[i]];
    const struct rounds_tile *as = &r->tiles[player_of(known, i / step, step)];
    return t->area * samples_of(t) * samples_of(&played->tiles[i / step]) / samples_of(as);
}

/* Returns the factor that what was not seen in the first round may make. */
static double unseen_of(const struct rounds *r, const struct known *known, enum foreseen which)
{
    static const double power[FORESEEN_COUNT] = {0.0, -1.0, 1.0};
    return r->report.rounds > 0 ? 1.0 : pow(UNSEEN, power[which] * (1.0 - known->share));
}

/* Tells the known tiles what they take, or in the first round all what these take on average. */
static void tell(struct rounds *r, const struct known *known, const struct rounds *played,
                 uint32_t step)
{
    const double trust = fmin(1.0, SEEN_TRUST * known->share);
    double sum = 0.0, *expected = &r->report.expected[played->foreseen];
    for (uint32_t i = 0; i < known->count; i++) {
        const double told = told_of(r, known, played, i, step);
        if (r->report.rounds > 0) r->tiles[known->tiles[i]].expected = told;
        sum += told;
    }
    *expected = 0.0;
    for (uint32_t i = 0; i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        const double before = t->area * FIRST_TIMES * samples_of(t);
        if (r->report.rounds == 0)
            t->expected = before * pow(sum / known->pixels * t->area / before, trust);
        *expected += t->expected;
    }
    *expected = fmax(*expected * unseen_of(r, known, played->foreseen),
                     (double)(r->report.paths + r->report.bounces));
}

/* Plays on some known tiles, for whose copies `tiles` has room. */
static void foresee(struct rounds *r, const struct known *known, struct rounds_tile *tiles,
                    enum foreseen which)
{
    const uint32_t step = (known->count + PLAYED_MAX - 1) / PLAYED_MAX;
    struct rounds now = *r, played;
    double all = 0.0, by[KINDS];
    now.foreseen = which;
    played = now;
    for (int kind = 0; kind < KINDS; kind++) {
        add_fall(&played, kind);
        by[kind] = surprise_of(&now, kind);
    }
    for (uint32_t i = 0; i < known->count; i++) {
        tiles[0] = r->tiles[known->tiles[i]];
        end_tile(&now, &tiles[0], by);
        all += squares_of(&tiles[0]);
    }
    played.tiles = tiles;
    played.count = (known->count + step - 1) / step;
    for (uint32_t i = 0; i < played.count; i++) {
        tiles[i] = r->tiles[player_of(known, i, step)];
        end_tile(&now, &tiles[i], by);
    }
    if (all > 0.0) play(&played, wanted_of(r, known) * squares(&played) / all);
    tell(r, known, &played, step);
}

void rounds_foresee(struct rounds *r)
{
    struct known known = {.tiles = malloc(r->count * sizeof *known.tiles)};
    struct rounds_tile *tiles = malloc(r->count * sizeof *tiles);
    uint32_t *like = malloc(r->count * sizeof *like);
    if (known.tiles && tiles && like) find_known(r, &known, like);
    /* Without memory, or before anything was seen, what was foreseen stays. */
    for (int k = FORESEEN_COUNT - 1; k >= 0 && known.count > 0; k--)
        foresee(r, &known, tiles, (enum foreseen)k);
    free(known.tiles);
    free(tiles);
    free(like);
}

double rounds_due(const struct rounds *r, uint32_t tile)
{
    const struct rounds_tile *t = &r->tiles[tile];
    return fmax(0.0, t->expected - t->area * ((double)t->kinds[PATHS].n + t->kinds[BOUNCES].n));
}
