#include <math.h>
#include <stdlib.h>

#include "proto/limits.h"
#include "server/job/frame/rounds_work.h"

#define GROWTH_MAX 4.0
#define GROWTH_MIN 1.02 /* less is not worth a pass */
#define CHUNK      LIMIT_PASS_SPP
#define CHUNK_SIDE 8u
#define REST_MIN   0.25 /* of what no sample lowers, squared: beside it the rest is small */

_Static_assert(CHUNK_SIDE *CHUNK_SIDE == CHUNK, "bounce rays of a full pass");

/* Returns how many samples a pixel may take, before any error is known: what eight pictures took
 * within a factor of four, or twice the first round's if that is more. */
static double guess(const struct plan *plan, uint32_t first, enum foreseen which)
{
    static const double times[FORESEEN_COUNT] = {1.0, 0.25, 4.0};
    const double target = (double)plan->target_error, usual = 0.05 / (target * target);
    return fmax(first, times[which] * fmax(2.0 * first, fmin(usual, plan->spp_max)));
}

int rounds_create(const struct plan *plan, struct rounds **out)
{
    *out = NULL;
    struct rounds *r = calloc(1, sizeof *r);
    if (!r) return ERR_MEMORY;
    const uint32_t l = plan->indirect_strata_per_axis;
    int error = tile_grid_init(&r->grid, plan->width_px, plan->height_px, plan->tile_px);
    r->plan = plan;
    r->count = error ? 0 : tile_grid_count(&r->grid);
    r->pixels = (double)plan->width_px * plan->height_px;
    r->tiles = calloc(r->count ? r->count : 1, sizeof *r->tiles);
    if (!error && !r->tiles) error = ERR_MEMORY;
    if (error) {
        rounds_destroy(&r);
        return error;
    }
    for (uint32_t i = 0; i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        t->area = (uint32_t)rect_area(tile_grid_rect(&r->grid, i));
        t->kinds[PATHS].more = plan->paths.spp;
        t->kinds[BOUNCES].more = l * l;
        t->passes = plan_pass_count(plan);
        r->report.paths += (uint64_t)t->area * plan->paths.spp;
        r->report.bounces += (uint64_t)t->area * l * l;
        for (int k = 0; k < FORESEEN_COUNT; k++)
            r->report.expected[k] +=
                t->area * guess(plan, plan->paths.spp + l * l, (enum foreseen)k);
        /* Where it takes many times the first round, that is over early, and tells. */
        t->expected = t->area * FIRST_TIMES * (plan->paths.spp + l * l);
    }
    *out = r;
    return 0;
}

void rounds_destroy(struct rounds **rounds)
{
    if (!*rounds) return;
    free((*rounds)->tiles);
    free(*rounds);
    *rounds = NULL;
}

/* -- growth -- */

/* Returns the root of an order of x >= 1 by Newton's method from above, without the C library's
 * powers, whose bits depend on the CPU. Factors of 2^order are taken out first, since from far away
 * the method converges slowly. */
static double root_of(double x, int order)
{
    const double step = (double)(1u << order);
    double scale = 1.0, root;
    for (; x >= step && x < INFINITY; x /= step) scale *= 2.0;
    root = x;
    for (int i = 0; i < 64; i++) {
        double power = root; /* root^(order - 1) */
        for (int k = 2; k < order; k++) power *= root;
        const double next = root - (root * power - x) / (order * power);
        if (!(next < root)) break;
        root = next;
    }
    return scale * root;
}

/* Returns x^(3/5) of any x > 0. */
static double three_fifths(double x)
{
    const double root = x < 1.0 ? 1.0 / root_of(1.0 / x, 5) : root_of(x, 5);
    return root * root * root;
}

/* Returns the growth where lambda is 1. */
static double scale_of(double gain, enum law law)
{
    if (!(gain > 0.0)) return 0.0;
    return law == LAW_MEAN ? sqrt(gain) : three_fifths(2.0 / 3.0 * gain);
}

static struct level level_at(double lambda)
{
    return (struct level){lambda, {sqrt(lambda), three_fifths(lambda)}};
}

double rounds_growth(const struct rounds *r, const struct kind *k, int kind,
                     const struct level *level)
{
    if (k->n == 0 || !(k->variance > 0.0)) return 1.0;
    const double most = (double)most_of(r, kind) / k->n;
    const double free = k->scale / level->divisor[law_of(r, kind)];
    return fmax(fmin(free, most), 1.0);
}

/* Returns the remaining part of a squared error; r^(-2/3) is the cube root's inverse square. */
static double remains(double variance, enum law law, double r)
{
    if (law == LAW_MEAN) return variance / r;
    const double root = root_of(r, 3);
    return variance / (root * root);
}

/* Returns the squared errors at a level, without those that no sample lowers. */
static double squares_at(const struct rounds *r, const struct level *level)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < r->count; i++)
        for (int kind = 0; kind < KINDS; kind++) {
            const struct kind *k = &r->tiles[i].kinds[kind];
            sum += remains(k->variance, law_of(r, kind), rounds_growth(r, k, kind, level));
        }
    return sum;
}

/* Returns the largest gain of one sample more now. */
static double gain_max(const struct rounds *r)
{
    double most = 0.0;
    for (uint32_t i = 0; i < r->count; i++) {
        const struct rounds_tile *t = &r->tiles[i];
        for (int kind = 0; kind < KINDS; kind++)
            if (t->kinds[kind].n > 0)
                most = fmax(most, t->kinds[kind].variance / t->area / t->kinds[kind].n);
    }
    return most;
}

struct level rounds_solve(const struct rounds *r, double wanted)
{
    const double most = gain_max(r);
    double low = most, high = most;
    struct level level = level_at(most > 0.0 ? most : 1.0);
    for (int i = 0; i < 200 && low > 0.0 && squares_at(r, &level) > wanted; i++) {
        high = low;
        low *= 0.5;
        level = level_at(low);
    }
    for (int i = 0; i < 40 && low < high; i++) {
        const double middle = 0.5 * (low + high);
        const struct level at = level_at(middle);
        if (squares_at(r, &at) > wanted)
            high = middle;
        else
            low = middle;
    }
    return level_at(low > 0.0 ? low : 1.0);
}

/* -- passes -- */

/* Returns the number next to n and above `before` that is a multiple of a power of two near an
 * eighth of it: the path tracer's sequence is stratified best where it is cut there. */
static uint32_t rounded(double n, uint32_t before)
{
    uint32_t step = 4;
    while (step * 16.0 <= n) step *= 2;
    const uint32_t near = (uint32_t)(n / step + 0.5) * step;
    return near > before ? near : (before / step + 1) * step;
}

/* Bounce rays come in full passes and one of an even l. */
static uint32_t bounces_of(double more)
{
    const uint32_t whole = (uint32_t)(more / CHUNK);
    const double rest = more - (double)whole * CHUNK;
    uint32_t l = 0;
    while ((double)l * l < rest) l += 2;
    return whole * CHUNK + l * l;
}

static uint32_t strata_of(uint32_t bounces)
{
    uint32_t l = 0;
    while (l * l < bounces) l += 2;
    return l;
}

/* `room` samples fit the passes that are left. */
static uint32_t more_of(const struct rounds *r, const struct kind *k, int kind, double by,
                        uint32_t room)
{
    const double wanted = fmin(by, GROWTH_MAX);
    const uint32_t most = most_of(r, kind);
    if (wanted < GROWTH_MIN || k->n >= most) return 0;
    const uint32_t left = most - k->n < room ? most - k->n : room;
    if (kind == PATHS) {
        const uint32_t paths = rounded(wanted * k->n, k->n) - k->n;
        return paths < left ? paths : left;
    }
    uint32_t bounces = bounces_of((wanted - 1.0) * k->n);
    while (bounces > left) { /* the next less that passes can have */
        const uint32_t rest = bounces % CHUNK, l = strata_of(rest ? rest : CHUNK);
        bounces -= rest ? rest : CHUNK;
        bounces += (l - 2) * (l - 2);
    }
    return bounces;
}

static uint32_t passes_of(uint32_t samples)
{
    return (samples + CHUNK - 1) / CHUNK;
}

uint64_t rounds_deal(struct rounds *r, const struct level *level)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        const uint32_t room = (LIMIT_PASSES - t->first_pass) * CHUNK;
        uint32_t passes = 0;
        for (int kind = 0; kind < KINDS; kind++) {
            struct kind *k = &t->kinds[kind];
            k->more = k->n > 0 ? more_of(r, k, kind, rounds_growth(r, k, kind, level), room) : 0;
            *(kind == PATHS ? &r->report.paths : &r->report.bounces) += (uint64_t)t->area * k->more;
            passes = passes_of(k->more) > passes ? passes_of(k->more) : passes;
        }
        t->passes = passes;
        sum += passes;
    }
    return sum;
}

/* -- rounds -- */

void rounds_set_scale(const struct rounds *r, struct rounds_tile *t, int kind)
{
    struct kind *k = &t->kinds[kind];
    k->scale = k->n > 0 ? scale_of(k->variance / t->area / k->n, law_of(r, kind)) : 0.0;
}

/* Takes the round's samples and errors in. */
static void end_round(struct rounds *r, const struct rounds_error *errors)
{
    struct rounds_report *report = &r->report;
    double variance = 0.0, fixed = 0.0, luminance = 0.0;
    report->rounds++;
    for (uint32_t i = 0; i < r->count; i++) {
        r->tiles[i].seen = errors[i];
        r->tiles[i].seen_px = r->tiles[i].area;
    }
    rounds_learn(r);
    for (uint32_t i = 0; i < r->count; i++) {
        struct rounds_tile *t = &r->tiles[i];
        t->first_pass += t->passes;
        t->passes = 0;
        t->seen = (struct rounds_error){0};
        t->seen_px = 0;
        t->glanced = false;
        for (int kind = 0; kind < KINDS; kind++) t->glance[kind] = 0.0;
        for (int kind = 0; kind < KINDS; kind++) {
            struct kind *k = &t->kinds[kind];
            k->n += k->more;
            k->more = 0;
            k->variance = variance_of(&errors[i], kind);
            rounds_set_scale(r, t, kind);
            variance += k->variance;
        }
        t->expected = t->area * ((double)t->kinds[PATHS].n + t->kinds[BOUNCES].n);
        fixed += errors[i].variance[ERROR_SOURCE_CENTRES];
        luminance += errors[i].luminance;
    }
    const double mean = r->mean = luminance / r->pixels;
    const bool lit = mean > 0.0;
    report->reached = lit ? sqrt((variance + fixed) / r->pixels) / mean : 0.0;
    report->fixed = lit ? sqrt(fixed / r->pixels) / mean : 0.0;
    report->met = report->reached <= (double)r->plan->target_error;
}

double rounds_rest_wanted(const struct rounds *r, double fixed)
{
    const double error = AIM * (double)r->plan->target_error;
    const double rest = error * error - fixed * fixed;
    return rest > 0.0 ? rest : REST_MIN * fixed * fixed;
}

bool rounds_decide(struct rounds *r, const struct rounds_error *errors, uint32_t *more_passes)
{
    end_round(r, errors);
    const double mean = r->mean;
    for (uint32_t i = 0; i < r->count; i++) more_passes[i] = 0;
    if (r->report.met || r->report.rounds >= ROUNDS_MAX) return false;
    const double wanted = rounds_rest_wanted(r, r->report.fixed), reached = r->report.reached,
                 fixed = r->report.fixed;
    if (reached * reached - fixed * fixed <= wanted) return false;
    struct level level = rounds_solve(r, wanted * mean * mean * r->pixels);
    uint64_t passes = rounds_deal(r, &level);
    for (int i = 0; i < 64 && passes == 0; i++) {
        level = level_at(0.5 * level.lambda);
        passes = rounds_deal(r, &level);
    }
    for (uint32_t i = 0; i < r->count; i++) more_passes[i] = r->tiles[i].passes;
    r->report.threshold = mean > 0.0 ? sqrt(level.lambda) / mean : 0.0;
    if (passes > 0) rounds_foresee(r);
    return passes > 0;
}

struct plan_pass rounds_pass(const struct rounds *r, uint32_t tile, uint32_t number)
{
    const struct rounds_tile *t = &r->tiles[tile];
    if (number < plan_pass_count(r->plan)) return plan_scheduled_pass(r->plan, number);
    const uint32_t before = (number - t->first_pass) * CHUNK;
    const struct kind *paths = &t->kinds[PATHS], *bounces = &t->kinds[BOUNCES];
    struct plan_pass pass = {.number = number, .first = paths->n + before};
    const uint32_t paths_left = paths->more > before ? paths->more - before : 0;
    const uint32_t bounces_left = bounces->more > before ? bounces->more - before : 0;
    pass.count = paths_left < CHUNK ? paths_left : CHUNK;
    pass.strata = strata_of(bounces_left < CHUNK ? bounces_left : CHUNK);
    if (pass.count == 0) pass.first = 0;
    return pass;
}

struct rounds_report rounds_report(const struct rounds *r)
{
    return r->report;
}
