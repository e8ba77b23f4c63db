/* make simulate: frames on simulated farms, by the coordinator's own scheduling (schedule.h,
 * speculation.h, lease.h, tile_queue.h) and no sockets: how much longer they take than on a perfect
 * farm, with copies of late tiles and without.
 *
 *   simulate_farm [runs=N] [seed=N] [farm=NAME]
 *
 * Times are simulated. A perfect farm does the same work at its full speed to the end: no whole
 * tiles, no waiting, no knowledge missing. Prints one JSON line a farm: medians and worst of all
 * runs; status 1 when a bound is missed. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/limits.h"
#include "server/fleet/schedule.h"
#include "server/fleet/speculation.h"
#include "server/job/frame/tile_queue.h"
#include "tests/random.h"

#define WORKERS_MAX 256
#define QUEUE_MAX   (SCHEDULE_TILES_PER_THREAD * 16u)
#define LINK_MS     2.0     /* from a result to the next tile */
#define SILENCE_MS  10000.0 /* until a silent worker's tiles come back */
#define LOOK_MS     25.0    /* idle workers look for late tiles */
#define NEVER       1e300

struct farm {
    const char *name;
    int workers, threads_max;
    double spread;          /* speeds lie within this factor, evenly in its logarithm */
    double slow;            /* share of workers that are ten times slower */
    double killed, hanging; /* shares of workers that fail at some time */
    double tiles_each;      /* tiles a thread */
    double uneven;          /* deviation of the logarithm of a tile's work */
    double bound, worst;    /* of median and of worst time over the ideal, with copies */
};

static const struct farm farms[] = {
    /* Four workers of one thread, one of them at a tenth. */
    {"one_slow", 4, 1, 1, 0, 0, 0, 24, 0.3, 1.15, 1.3},
    {"even", 256, 4, 1, 0, 0, 0, 24, 0.3, 1.10, 1.2},
    {"uneven", 256, 8, 4, 0.1, 0, 0, 24, 0.3, 1.10, 1.2},
    {"uneven_killed", 256, 8, 4, 0.1, 0.1, 0, 24, 0.3, 1.10, 1.2},
    {"uneven_hanging", 256, 8, 4, 0.1, 0.05, 0.05, 24, 0.3, 1.10, 1.2},
    /* To know, not to reach: nobody knows which tiles are heavy, and the ideal starts with them;
     * and what takes three tiles a thread is over before anyone's pace is known. */
    {"heavy_tiles", 256, 8, 4, 0.1, 0.05, 0.05, 24, 0.6, 0, 0},
    {"short_frame", 256, 8, 4, 0.1, 0, 0, 3, 0.3, 0, 0},
};

struct worker {
    uint32_t threads;
    double speed; /* work a ms and thread */
    double killed_ms, hangs_ms, returned_ms;
    bool gone;
    struct lease_table leases;
    double ends_ms[QUEUE_MAX]; /* of leases begun, in the table's order */
};

struct run {
    const struct farm *farm;
    struct random random;
    bool copies;
    int count;
    struct worker workers[WORKERS_MAX];
    const struct lease_table *tables[WORKERS_MAX];
    uint32_t tiles;
    double *work; /* owned: of each tile */
    struct tile_queue *queue;
    double now_ms;
};

static double unit(struct random *r)
{
    return (double)random_unit(r);
}

static double normal(struct random *r)
{
    return sqrt(-2 * log(1 - unit(r))) * cos(2 * 3.14159265358979 * unit(r));
}

/* ---- the farm ---- */

static void make_worker(struct run *run, int i)
{
    const struct farm *f = run->farm;
    struct worker *w = &run->workers[i];
    memset(w, 0, sizeof *w);
    w->threads = 1 + (uint32_t)(unit(&run->random) * f->threads_max);
    w->speed = pow(f->spread, unit(&run->random) - 0.5) * 0.01;
    if (unit(&run->random) < f->slow) w->speed *= 0.1;
    if (strcmp(f->name, "one_slow") == 0 && i == 0) w->speed *= 0.1;
    w->killed_ms = w->hangs_ms = NEVER;
    const double fate = unit(&run->random);
    /* Some time in the first two seconds. */
    if (fate < f->killed)
        w->killed_ms = 2000 * unit(&run->random);
    else if (fate < f->killed + f->hanging)
        w->hangs_ms = 2000 * unit(&run->random);
    w->returned_ms = w->killed_ms < NEVER ? w->killed_ms : w->hangs_ms + SILENCE_MS;
    w->leases.threads = w->threads;
    run->tables[i] = &w->leases;
}

static int make_frame(struct run *run)
{
    struct tile_grid grid;
    uint32_t threads = 0;
    for (int i = 0; i < run->count; i++) threads += run->workers[i].threads;
    const int32_t side = (int32_t)ceil(sqrt(run->farm->tiles_each * threads));
    if (tile_grid_init(&grid, 64 * side, 64 * side, 64)) return -1;
    run->tiles = tile_grid_count(&grid);
    run->work = calloc(run->tiles, sizeof *run->work);
    if (!run->work || tile_queue_create(&grid, 64, 1, UINT32_MAX, &run->queue)) return -1;
    for (uint32_t i = 0; i < run->tiles; i++)
        run->work[i] = exp(run->farm->uneven * normal(&run->random));
    return 0;
}

static int compare_work(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*q > *p) - (*q < *p);
}

/* When a thread that is free at *free_ms would be done with a tile; NEVER when it fails before. */
static double done_ms(const struct worker *w, double free_ms, double work)
{
    const double ms = free_ms + work / w->speed;
    return ms < w->killed_ms && ms < w->hangs_ms ? ms : NEVER;
}

/* The heaviest tile first, each to the thread that is done with it first, by somebody who knows
 * what every tile takes, how fast everyone is and who will fail when: Graham 1969's rule for
 * machines of different speeds. < 0: no memory. */
static double ideal_ms(const struct run *run)
{
    double free_ms[WORKERS_MAX][16] = {{0}}, last = 0, *work = malloc(run->tiles * sizeof *work);
    if (!work) return -1;
    memcpy(work, run->work, run->tiles * sizeof *work);
    qsort(work, run->tiles, sizeof *work, compare_work);
    for (uint32_t t = 0; t < run->tiles; t++) {
        double first = NEVER, *thread = &free_ms[0][0];
        for (int i = 0; i < run->count; i++) {
            double *least = free_ms[i];
            for (uint32_t k = 1; k < run->workers[i].threads; k++)
                if (free_ms[i][k] < *least) least = &free_ms[i][k];
            const double ms = done_ms(&run->workers[i], *least, work[t]);
            if (ms >= first) continue;
            first = ms;
            thread = least;
        }
        *thread = first;
        last = first > last ? first : last;
    }
    free(work);
    return last;
}

/* ---- events ---- */

/* Leases that threads have come to, `after_ms` from now. */
static void begin(struct run *run, struct worker *w, double after_ms)
{
    for (uint32_t i = 0; i < lease_begun(&w->leases); i++)
        if (w->ends_ms[i] == 0)
            w->ends_ms[i] =
                run->now_ms + after_ms + run->work[w->leases.at[i].tile.index] / w->speed;
}

static void give(struct run *run, int i, uint32_t tile, uint32_t generation)
{
    struct worker *w = &run->workers[i];
    const struct lease lease = {.tile = {.frame_id = 1, .index = tile, .generation = generation},
                                .since_ms = (uint64_t)run->now_ms};
    w->ends_ms[w->leases.count] = 0;
    if (lease_add(&w->leases, &lease)) abort();
    begin(run, w, LINK_MS);
}

static void forget(struct worker *w, uint32_t at)
{
    memmove(&w->ends_ms[at], &w->ends_ms[at + 1], (QUEUE_MAX - 1 - at) * sizeof w->ends_ms[0]);
}

static void answer(struct run *run, int i, uint32_t at)
{
    struct worker *w = &run->workers[i];
    const struct fleet_tile tile = w->leases.at[at].tile;
    lease_answer(&w->leases, at, (uint64_t)run->now_ms);
    forget(w, at);
    begin(run, w, 0); /* it has the next one already */
    if (tile_queue_receive(run->queue, (uint64_t)i + 1, tile.index, tile.generation) ==
        VERDICT_ACCEPTED)
        tile_queue_land(run->queue, tile.index);
}

static void lose(struct run *run, int i)
{
    struct worker *w = &run->workers[i];
    w->gone = true;
    while (w->leases.count > 0) {
        const struct fleet_tile tile = w->leases.at[0].tile;
        lease_remove(&w->leases, 0, (uint64_t)run->now_ms);
        tile_queue_return(run->queue, (uint64_t)i + 1, tile.index, tile.generation,
                          TILE_GIVEN_BACK);
    }
}

static uint32_t wants(const struct worker *w)
{
    const uint32_t most = SCHEDULE_TILES_PER_THREAD * w->threads;
    return w->gone || w->leases.count >= most ? 0 : most - w->leases.count;
}

static void hand_tiles(struct run *run)
{
    struct schedule_worker offers[WORKERS_MAX];
    uint32_t give_each[WORKERS_MAX], tile, generation;
    int who[WORKERS_MAX], count = 0;
    for (int i = 0; i < run->count; i++)
        if (!run->workers[i].gone) {
            who[count] = i;
            offers[count++] = (struct schedule_worker){
                .threads = run->workers[i].threads,
                .want = wants(&run->workers[i]),
                .in_hand = run->workers[i].leases.count,
                .pace_ms = lease_pace_ms(&run->workers[i].leases, (uint64_t)run->now_ms)};
        }
    schedule_share(offers, (size_t)count, tile_queue_waiting(run->queue), give_each);
    for (bool any = true; any;) {
        any = false;
        for (int k = 0; k < count; k++) {
            if (give_each[k] == 0) continue;
            give_each[k]--;
            any = true;
            if (!tile_queue_lease(run->queue, (uint64_t)who[k] + 1, &tile, &generation)) return;
            give(run, who[k], tile, generation);
        }
    }
}

static void hand_copies(struct run *run)
{
    struct speculation late;
    uint32_t generation;
    for (int i = 0; i < run->count; i++) {
        struct worker *w = &run->workers[i];
        while (!w->gone && w->leases.count < w->threads &&
               speculation_find(run->tables, (size_t)run->count, (size_t)i, (uint64_t)run->now_ms,
                                &late)) {
            struct lease *lease = &run->workers[late.holder].leases.at[late.at];
            lease->copied = true;
            const uint32_t tile = lease->tile.index;
            if (tile_queue_copy(run->queue, (uint64_t)i + 1, tile, lease->tile.generation,
                                &generation))
                give(run, i, tile, generation);
        }
    }
}

/* The next thing that happens, and to whom; at: the lease that is answered, or UINT32_MAX. */
static double next_event(const struct run *run, int *who, uint32_t *at)
{
    double first = NEVER;
    for (int i = 0; i < run->count; i++) {
        const struct worker *w = &run->workers[i];
        if (w->gone) continue;
        if (w->returned_ms < first) {
            first = w->returned_ms;
            *who = i;
            *at = UINT32_MAX;
        }
        for (uint32_t k = 0; k < lease_begun(&w->leases); k++) {
            if (w->ends_ms[k] >= first || w->ends_ms[k] >= w->hangs_ms) continue;
            first = w->ends_ms[k];
            *who = i;
            *at = k;
        }
    }
    return first;
}

static double frame_ms(struct run *run)
{
    int who = 0;
    uint32_t at = 0;
    while (!tile_queue_complete(run->queue)) {
        hand_tiles(run);
        const bool tail = run->copies && tile_queue_waiting(run->queue) == 0;
        if (tail) hand_copies(run);
        const double ms = next_event(run, &who, &at);
        if (tail && ms > run->now_ms + LOOK_MS) {
            run->now_ms += LOOK_MS;
            continue;
        }
        if (ms == NEVER) return NEVER;
        run->now_ms = ms;
        if (at == UINT32_MAX)
            lose(run, who);
        else
            answer(run, who, at);
    }
    return run->now_ms;
}

/* ---- figures ---- */

/* Time over the ideal one of a frame; < 0: no memory. */
static double simulate(const struct farm *farm, uint64_t seed, bool copies, uint64_t *copied)
{
    struct run *run = calloc(1, sizeof *run);
    if (!run) return -1;
    run->farm = farm;
    run->copies = copies;
    run->random.state = seed;
    run->count = farm->workers;
    for (int i = 0; i < run->count; i++) make_worker(run, i);
    double ratio = -1;
    if (make_frame(run) == 0) {
        ratio = frame_ms(run) / ideal_ms(run);
        *copied += tile_queue_copied(run->queue);
    }
    tile_queue_destroy(&run->queue);
    for (int i = 0; i < run->count; i++) lease_table_fini(&run->workers[i].leases);
    free(run->work);
    free(run);
    return ratio;
}

static int compare_doubles(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* Median and worst, over the seeds. False when there is no memory. */
static bool measure(const struct farm *farm, uint64_t seed, size_t runs, bool copies, double *ratio,
                    double found[2], uint64_t *copied)
{
    for (size_t i = 0; i < runs; i++) {
        ratio[i] = simulate(farm, seed + i, copies, copied);
        if (ratio[i] < 0) return false;
    }
    qsort(ratio, runs, sizeof *ratio, compare_doubles);
    found[0] = ratio[runs / 2];
    found[1] = ratio[runs - 1];
    return true;
}

/* 0, 1 when a bound is missed, 2 without memory. */
static int print_farm(const struct farm *farm, uint64_t seed, size_t runs)
{
    double with[2], without[2], *ratio = calloc(runs, sizeof *ratio);
    uint64_t copied = 0, none = 0;
    if (!ratio || !measure(farm, seed, runs, true, ratio, with, &copied) ||
        !measure(farm, seed, runs, false, ratio, without, &none)) {
        free(ratio);
        return 2;
    }
    free(ratio);
    const bool ok = farm->bound == 0 || (with[0] <= farm->bound && with[1] <= farm->worst);
    printf("{\"farm\":\"%s\",\"workers\":%d,\"runs\":%zu,\"time_over_ideal\":%.4f,\"worst\":%.4f,"
           "\"without_copies\":%.4f,\"worst_without\":%.4f,\"copies\":%.1f,",
           farm->name, farm->workers, runs, with[0], with[1], without[0], without[1],
           (double)copied / (double)runs);
    if (farm->bound > 0) printf("\"bound\":\"<= %.2f, worst <= %.2f\",", farm->bound, farm->worst);
    printf("\"ok\":%s}\n", ok ? "true" : "false");
    fflush(stdout);
    return ok ? 0 : 1;
}

int main(int argc, char **argv)
{
    unsigned long runs = 1000, seed = 1;
    char farm[32] = "";
    int rc = 0;
    for (int i = 1; i < argc; i++) {
        if (sscanf(argv[i], "runs=%lu", &runs) == 1 && runs > 0) continue;
        if (sscanf(argv[i], "seed=%lu", &seed) == 1) continue;
        if (sscanf(argv[i], "farm=%31s", farm) == 1) continue;
        fprintf(stderr, "usage: simulate_farm [runs=N] [seed=N] [farm=NAME]\n");
        return 2;
    }
    for (size_t i = 0; i < sizeof farms / sizeof farms[0]; i++) {
        if (farm[0] && strcmp(farm, farms[i].name) != 0) continue;
        const int missed = print_farm(&farms[i], seed, runs);
        rc = missed > rc ? missed : rc;
    }
    return rc;
}
