/* How many samples a target will take in the end, for the time left. No picture depends on it.
 *
 * The rounds that are to come are played to their end: each deals samples as a true round does
 * (rounds.h), and errors then fall with the power of n by which they fell in the last round, or
 * at first with one that was usual. A round's own law is on the safe side, so that tiles get more
 * than they need: what is dealt tells the time, not what would do.
 *
 * A few tiles in which one path of nine met a lamp seem to have most of the error of the first
 * round, and have it no more when they have four times as many: what a tile has beyond so many
 * times the median does not count then, and with a filter counts as its root. */
#include <math.h>
#include <stdlib.h>

#include "server/job/frame/rounds_work.h"

#define OUTLIER      16.0
#define POWER_LEAST  0.5
#define POWER_MOST   2.0
#define GLANCE_TRUST 4.0   /* a quarter of the picture tells of the rest */
#define PLAYED_MAX   1024u /* tiles; of more, each plays for those behind it */

static int by_value(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* Returns the variance of one sample, a pixel; 0: none. */
static double single(const struct rounds_tile *t, int kind)
{
    const struct kind *k = &t->kinds[kind];
    return k->n > 0 && k->variance > 0.0 ? k->variance * k->n / t->area : 0.0;
}

/* Returns the most that a tile's single variance should count for. Without memory: anything. */
static double cap_of(const struct rounds *r, int kind)
{
    size_t count = 0;
    double *values = calloc(r->count, sizeof *values);
    if (!values || r->report.rounds > 1) {
        free(values);
        return INFINITY;
    }
    for (uint32_t i = 0; i < r->count; i++) {
        const double value = single(&r->tiles[i], kind);
        if (value > 0.0) values[count++] = value;
    }
    qsort(values, count, sizeof *values, by_value);
    const double cap = count > 0 ? OUTLIER * values[count / 2] : INFINITY;
    free(values);
    return cap;
}

/* Returns what would be left of squared errors that fall with a power, over the tiles whose samples
 * grew. */
static double left_at(const struct rounds *r, int kind, double power)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < r->count; i++) {
        const struct kind *k = &r->tiles[i].kinds[kind];
        if (k->n > 0 && k->more > 0)
            sum += k->variance * pow((double)k->n / ((double)k->n + k->more), power);
    }
    return sum;
}

void rounds_measure_powers(struct rounds *r, const struct rounds_error *errors)
{
    for (int kind = 0; kind < KINDS; kind++) {
        double low = POWER_LEAST, high = POWER_MOST, left = 0.0;
        for (uint32_t i = 0; i < r->count; i++) {
            const struct kind *k = &r->tiles[i].kinds[kind];
            if (k->n > 0 && k->more > 0) left += variance_of(&errors[i], kind);
        }
        if (!(left > 0.0)) continue;
        for (int i = 0; i < 20; i++) {
            const double middle = 0.5 * (low + high);
            *(left_at(r, kind, middle) > left ? &low : &high) = middle;
        }
        r->powers[kind] = 0.5 * (low + high);
    }
}

/* Ends a round that is played: its samples count, and errors fall. Returns what is left of them. */
static double end_played(struct rounds *r)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        t->first_pass += t->passes;
        t->passes = 0;
        for (int kind = 0; kind < KINDS; kind++) {
            struct kind *k = &t->kinds[kind];
            const double before = k->n;
            k->n += k->more;
            if (before > 0.0) k->variance *= pow(before / (double)k->n, r->powers[kind]);
            k->more = 0;
            rounds_set_scale(r, t, kind);
            sum += k->variance;
        }
    }
    return sum;
}

static void cap(struct rounds *r, const double caps[KINDS])
{
    for (uint32_t i = 0; i < r->count; i++)
        for (int kind = 0; kind < KINDS; kind++) {
            const double by =
                caps[kind] / single(&r->tiles[i], kind); /* of 0: infinite, or caps are, too */
            if (!(by < 1.0)) continue;
            r->tiles[i].kinds[kind].variance *= law_of(r, kind) == LAW_MEAN ? by : sqrt(by);
        }
}

static double sum_of(const struct rounds *r)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < r->count; i++)
        for (int kind = 0; kind < KINDS; kind++) sum += r->tiles[i].kinds[kind].variance;
    return sum;
}

static void play(struct rounds *r, double wanted)
{
    double left = end_played(r);
    for (uint32_t k = r->report.rounds; k < ROUNDS_MAX && left > wanted / (AIM * AIM); k++) {
        const struct level level = rounds_solve(r, wanted);
        if (rounds_deal(r, &level) == 0) break;
        left = end_played(r);
    }
}

static double samples_of(const struct rounds_tile *t)
{
    return (double)t->kinds[PATHS].n + t->kinds[PATHS].more + t->kinds[BOUNCES].n +
           t->kinds[BOUNCES].more;
}

/* Returns the tile that plays for those of its group. Tiles at even steps would be of few columns.
 */
static uint32_t player_of(const struct rounds *r, uint32_t group, uint32_t step)
{
    const uint32_t tile = group * step + (group * UINT32_C(2654435769) >> 16) % step;
    return tile < r->count ? tile : group * step;
}

void rounds_forecast(struct rounds *r, double wanted)
{
    const double caps[KINDS] = {cap_of(r, PATHS), cap_of(r, BOUNCES)};
    const uint32_t step = (r->count + PLAYED_MAX - 1) / PLAYED_MAX;
    struct rounds played = *r;
    played.count = (r->count + step - 1) / step;
    played.tiles = malloc(played.count * sizeof *played.tiles);
    for (uint32_t i = 0; played.tiles && i < played.count; i++)
        played.tiles[i] = r->tiles[player_of(r, i, step)];
    if (played.tiles) {
        const double share = sum_of(&played) / sum_of(r); /* rounds are dealt for errors above 0 */
        cap(&played, caps);
        play(&played, wanted * share);
    }
    r->report.expected = 0.0;
    for (uint32_t i = 0; i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        const struct rounds_tile *as = &r->tiles[player_of(r, i / step, step)];
        const double by = played.tiles ? samples_of(&played.tiles[i / step]) / samples_of(as) : 1.0;
        t->expected = t->area * samples_of(t) * by;
        r->report.expected += t->expected;
    }
    free(played.tiles);
}

/* Returns the samples a pixel that a glance foresees. */
static double glanced(struct rounds *seen, double pixels, double luminance, double fixed)
{
    const double mean = luminance / pixels,
                 caps[KINDS] = {cap_of(seen, PATHS), cap_of(seen, BOUNCES)};
    double sum = 0.0;
    if (!(mean > 0.0)) return 0.0;
    seen->report.fixed = sqrt(fixed / pixels) / mean;
    cap(seen, caps);
    play(seen, rounds_rest_wanted(seen) * mean * mean * pixels);
    for (uint32_t i = 0; i < seen->count; i++)
        sum += seen->tiles[i].area * samples_of(&seen->tiles[i]);
    return sum / pixels;
}

void rounds_glance(struct rounds *r, const struct rounds_error *errors, const uint32_t *areas,
                   uint32_t count)
{
    struct rounds seen = *r;
    double pixels = 0.0, luminance = 0.0, fixed = 0.0;
    seen.count = count;
    seen.tiles = calloc(count, sizeof *seen.tiles);
    if (!seen.tiles) return; /* what was foreseen stays */
    for (uint32_t i = 0; i < count; i++) {
        seen.tiles[i].area = areas[i];
        for (int kind = 0; kind < KINDS; kind++)
            seen.tiles[i].kinds[kind] = (struct kind){.variance = variance_of(&errors[i], kind),
                                                      .n = r->tiles[0].kinds[kind].more};
        pixels += areas[i];
        luminance += errors[i].luminance;
        fixed += errors[i].variance[ERROR_SOURCE_CENTRES];
    }
    const double told = pixels > 0.0 ? glanced(&seen, pixels, luminance, fixed) : 0.0;
    const double trust = fmin(1.0, GLANCE_TRUST * pixels / r->pixels);
    if (told > 0.0) r->report.expected = 0.0;
    for (uint32_t i = 0; told > 0.0 && i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        t->expected *= pow(told * t->area / t->expected, trust);
        r->report.expected += t->expected;
    }
    free(seen.tiles);
}

double rounds_due(const struct rounds *r, uint32_t tile)
{
    const struct rounds_tile *t = &r->tiles[tile];
    return fmax(0.0, t->expected - t->area * ((double)t->kinds[PATHS].n + t->kinds[BOUNCES].n));
}
