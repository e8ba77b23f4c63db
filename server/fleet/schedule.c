#include "server/fleet/schedule.h"

/* Queues are filled in levels of an eighth of a tile a thread. */
#define LEVELS_PER_TILE 8u

static uint32_t at_max(uint32_t a, uint64_t b)
{
    return a < b ? a : (uint32_t)b;
}

uint32_t schedule_depth(uint32_t threads, uint64_t threads_total, uint64_t supply)
{
    uint32_t full = SCHEDULE_TILES_PER_THREAD * threads;
    if (supply / SCHEDULE_TILES_PER_THREAD >= threads_total) return full;
    /* Its part of what is left, rounded up; the products fit: supply < 2 threads_total here. */
    uint64_t fair = (supply * threads + threads_total - 1) / threads_total;
    return at_max(full, threads + fair);
}

/* All workers together. */
struct farm {
    uint64_t threads;
    double typical_ms; /* pace of a thread, harmonic mean over those whose pace is known; 0: none */
    double left_ms;    /* until all tiles are done, if all threads worked to the end */
};

static struct farm add_up(const struct schedule_worker *workers, size_t count, uint64_t supply)
{
    struct farm farm = {0};
    double known = 0, tiles_per_ms = 0, tiles = (double)supply;
    for (size_t i = 0; i < count; i++) {
        farm.threads += workers[i].threads;
        tiles += workers[i].in_hand;
        if (workers[i].pace_ms == 0) continue;
        known += workers[i].threads;
        tiles_per_ms += workers[i].threads / workers[i].pace_ms;
    }
    if (known == 0) return farm;
    farm.typical_ms = known / tiles_per_ms;
    farm.left_ms = tiles * farm.typical_ms / (double)farm.threads;
    return farm;
}

/* Tiles that it would be done with in time. */
static uint32_t timely(const struct schedule_worker *w, const struct farm *farm)
{
    const double rounds = w->pace_ms > 0 ? (farm->left_ms + farm->typical_ms) / w->pace_ms
                                         : SCHEDULE_TILES_PER_THREAD;
    return rounds < SCHEDULE_TILES_PER_THREAD ? w->threads * (uint32_t)rounds
                                              : w->threads * SCHEDULE_TILES_PER_THREAD;
}

/* Returns the tiles that bring worker w, which holds in_hand and was given `given`, up to `target`.
 */
static uint32_t missing(const struct schedule_worker *w, uint32_t given, uint32_t target)
{
    uint32_t held = w->in_hand + given;
    uint32_t room = target > held ? target - held : 0;
    return at_max(room, w->want - given);
}

void schedule_share(const struct schedule_worker *workers, size_t count, uint64_t supply,
                    uint32_t *give)
{
    for (size_t i = 0; i < count; i++) give[i] = 0;
    const struct farm farm = add_up(workers, count, supply);
    const uint64_t left_at_start = supply;
    for (uint32_t level = 1; level <= SCHEDULE_TILES_PER_THREAD * LEVELS_PER_TILE; level++) {
        for (size_t i = 0; i < count && supply > 0; i++) {
            const struct schedule_worker *w = &workers[i];
            if (w->want == give[i]) continue;
            uint32_t depth = schedule_depth(w->threads, farm.threads, left_at_start);
            depth = at_max(depth, timely(w, &farm));
            uint32_t target = (w->threads * level + LEVELS_PER_TILE - 1) / LEVELS_PER_TILE;
            uint32_t tiles = at_max(missing(w, give[i], at_max(target, depth)), supply);
            give[i] += tiles;
            if (supply != UINT64_MAX) supply -= tiles;
        }
    }
}
