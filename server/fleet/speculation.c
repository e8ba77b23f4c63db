#include "server/fleet/speculation.h"

/* A copy should take at most this part of the time that it might save: estimates are rough. */
#define COPY_PART 0.75
/* Time from a result to the next tile, over any link: shorter waits are not worth a copy. */
#define LINK_MS 10.0
/* A worker that takes longer than this many typical paces gets no copies: a faster one will be free
 * before. */
#define PACES_MAX 2.0

/* Returns how long a thread of the worker takes for a tile; `otherwise` if it has answered none. */
static double pace_of(const struct lease_table *t, double otherwise)
{
    return t->pace_ms > 0 ? t->pace_ms : otherwise;
}

static double left_of_begun(const struct lease *lease, double pace_ms, uint64_t now_ms)
{
    const double since = (double)(now_ms - lease->begun_ms), left = pace_ms - since;
    return left > 0.5 * since ? left : 0.5 * since;
}

/* The last of a worker's queue that can be copied is the one that is waited for longest. A lease
 * behind those under work begins when the one a round before it ends. */
static void look_at(const struct lease_table *t, double pace_ms, uint64_t now_ms,
                    struct speculation *worst)
{
    const uint32_t begun = lease_begun(t);
    for (uint32_t i = 0; i < t->count; i++) {
        if (t->at[i].copied) continue;
        const uint32_t rounds = i / begun;
        const double left = left_of_begun(&t->at[i % begun], pace_ms, now_ms) + rounds * pace_ms;
        if (left <= worst->gain_ms) continue;
        worst->gain_ms = left;
        worst->at = i;
    }
}

/* Returns the harmonic mean of a thread's pace over the workers whose pace is known; 0: none. */
static double typical_ms(const struct lease_table *const *tables, size_t count)
{
    double threads = 0, tiles_per_ms = 0;
    for (size_t i = 0; i < count; i++) {
        if (!tables[i] || tables[i]->pace_ms == 0) continue;
        const double own = tables[i]->threads > 0 ? tables[i]->threads : 1;
        threads += own;
        tiles_per_ms += own / tables[i]->pace_ms;
    }
    return threads > 0 ? threads / tiles_per_ms : 0;
}

bool speculation_find(const struct lease_table *const *tables, size_t count, size_t idle,
                      uint64_t now_ms, struct speculation *out)
{
    bool found = false;
    out->gain_ms = 0;
    if (tables[idle]->pace_ms > PACES_MAX * typical_ms(tables, count)) return false;
    for (size_t i = 0; i < count; i++) {
        if (i == idle || !tables[i]) continue;
        /* A worker without results is taken to be as fast as the other. */
        const double own = pace_of(tables[idle], tables[i]->pace_ms);
        if (own == 0) continue;
        struct speculation worst = {.holder = i, .gain_ms = (own + LINK_MS) / COPY_PART};
        const double least = worst.gain_ms;
        look_at(tables[i], pace_of(tables[i], own), now_ms, &worst);
        if (worst.gain_ms <= least || worst.gain_ms - own <= out->gain_ms) continue;
        *out = worst;
        out->gain_ms -= own;
        found = true;
    }
    return found;
}
