/* How many samples a target will take in the end, for the time left. No picture depends on it.
 *
 * It is solved for as rounds are (rounds.h), but in one step, and by other assumptions, which are
 * measured: ten pictures took 0.4 to 1.4 times what the first round foretold, and 0.9 to 1.1 times
 * what the second did. (The rounds' own law, made to be on the safe side, foretold up to eighty
 * times as many.)
 *
 * - Squared errors fall as 1 / n under filters, too. Those of the Cornell box, a living room and a
 *   gazebo fell with the powers 1 to 1.5 from 4 to 64 samples.
 * - A few tiles in which one path of nine met a lamp seem to have most of the error, and have it no
 *   more when they have four times as many. Without a filter a tile counts for at most so many
 *   times the median; with one, the truth lies between that and what it seems to have. */
#include <math.h>
#include <stdlib.h>

#include "server/job/frame/rounds_work.h"

#define OUTLIER 16.0

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
    if (!values) return INFINITY;
    for (uint32_t i = 0; i < r->count; i++) {
        const double value = single(&r->tiles[i], kind);
        if (value > 0.0) values[count++] = value;
    }
    qsort(values, count, sizeof *values, by_value);
    const double cap = count > 0 ? OUTLIER * values[count / 2] : INFINITY;
    free(values);
    return cap;
}

/* Returns samples a pixel where one more gains lambda: at least those that are dealt. */
static double samples_at(const struct rounds *r, const struct rounds_tile *t, int kind, double cap,
                         double lambda)
{
    const struct kind *k = &t->kinds[kind];
    const double now = (double)k->n + k->more, free = sqrt(fmin(single(t, kind), cap) / lambda);
    return fmax(now, fmin(free, most_of(r, kind)));
}

static double squares_at(const struct rounds *r, const double caps[KINDS], double lambda)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < r->count; i++)
        for (int kind = 0; kind < KINDS; kind++) {
            const struct rounds_tile *t = &r->tiles[i];
            const double variance = fmin(single(t, kind), caps[kind]);
            if (variance > 0.0)
                sum += t->area * variance / samples_at(r, t, kind, caps[kind], lambda);
        }
    return sum;
}

/* Returns the largest lambda, by a factor of 1.1, at which no more than `wanted` is left; or one at
 * which all have the most samples. */
static double solve(const struct rounds *r, const double caps[KINDS], double wanted)
{
    double lambda = 0.0;
    for (uint32_t i = 0; i < r->count; i++)
        for (int kind = 0; kind < KINDS; kind++)
            lambda = fmax(lambda, fmin(single(&r->tiles[i], kind), caps[kind]));
    for (int i = 0; i < 400 && lambda > 0.0 && squares_at(r, caps, lambda) > wanted; i++)
        lambda /= 1.1;
    return lambda;
}

void rounds_forecast(struct rounds *r, double wanted)
{
    const double capped[KINDS] = {cap_of(r, PATHS), cap_of(r, BOUNCES)};
    const double whole[KINDS] = {law_of(r, PATHS) == LAW_MEAN ? capped[PATHS] : INFINITY, INFINITY};
    const double lambdas[] = {solve(r, capped, wanted), solve(r, whole, wanted)};
    r->report.expected = 0.0;
    for (uint32_t i = 0; i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        t->expected = 0.0;
        for (int kind = 0; lambdas[0] > 0.0 && kind < KINDS; kind++)
            t->expected += t->area * sqrt(samples_at(r, t, kind, capped[kind], lambdas[0]) *
                                          samples_at(r, t, kind, whole[kind], lambdas[1]));
        r->report.expected += t->expected;
    }
}

double rounds_due(const struct rounds *r, uint32_t tile)
{
    const struct rounds_tile *t = &r->tiles[tile];
    return fmax(0.0, t->expected - t->area * ((double)t->kinds[PATHS].n + t->kinds[BOUNCES].n));
}
