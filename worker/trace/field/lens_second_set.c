#include "worker/trace/field/lens_second_set.h"

#include <math.h>
#include <string.h>

#include "worker/trace/hit/block_store.h"

static bool choose(const struct path_context *c, const struct block *block,
                   const uint8_t *strata_map, struct lens_second_set *m)
{
    m->block = *block;
    m->block.whole = false;
    for (int i = 0; i < LANES; i++) {
        const bool asks =
            block->kept.on[i] && strata_map[block->element[i]] == PLAN_LENS_EXTRA_STRATA;
        m->block.kept.on[i] = asks ? -1 : 0;
    }
    const uint32_t pixels = lanes_count(&m->block.kept);
    c->counters->value[COUNTER_SKIPPED_ENOUGH] += lanes_count(&block->kept) - pixels;
    return pixels > 0;
}

/* Samples that are not finite count as black. */
static void add(const struct path_context *c, const struct path_radiance *h, uint32_t count,
                struct lens_second_set *m)
{
    const struct path_rgb *e = &h->emission, *d = &h->direct, *n = &h->indirect;
    for (size_t k = 0; k < (size_t)count * LANES; k++) {
        const float rgb[3] = {e->r[k] + d->r[k] + n->r[k], e->g[k] + d->g[k] + n->g[k],
                              e->b[k] + d->b[k] + n->b[k]};
        const size_t lane = k % LANES;
        m->seen[lane] += h->coverage[k];
        if (!(rgb[0] < INFINITY && rgb[1] < INFINITY && rgb[2] < INFINITY)) {
            c->counters->value[COUNTER_REJECTED_NOT_FINITE]++;
            continue;
        }
        for (int i = 0; i < 3; i++) {
            const double value = (double)fminf(rgb[i], LENS_RADIANCE_MAX);
            m->sum[lane][i] += value;
            m->sum[lane][3] += value * value;
        }
    }
}

static void store(const struct lens_second_set *m, struct samples *samples)
{
    const double count = PLAN_LENS_EXTRA_STRATA * PLAN_LENS_EXTRA_STRATA;
    for (uint32_t k = 0; k < 4; k++) {
        _Alignas(LANES_ALIGN) float value[LANES];
        for (int i = 0; i < LANES; i++) {
            const double mean = m->sum[i][k] / count;
            value[i] = (float)(k < 3 ? mean : sqrt(mean));
        }
        block_store_f32(&m->block, value, samples_f32(samples, PLANE_LENS_SECOND_SET, k));
    }
    block_store_half(&m->block, m->seen, 1.0f / (float)count,
                     samples_u16(samples, PLANE_LENS_COVERAGE, 0));
}

void lens_second_set_trace(const struct path_context *c, const struct block *block,
                           const uint8_t *strata_map, struct lens_second_set *m,
                           struct path_scratch *paths, struct samples *samples)
{
    const uint32_t count = PLAN_LENS_EXTRA_STRATA * PLAN_LENS_EXTRA_STRATA;
    if (!choose(c, block, strata_map, m)) return;
    memset(m->sum, 0, sizeof m->sum);
    memset(m->seen, 0, sizeof m->seen);
    for (uint32_t done = 0; done < count;) {
        const uint32_t left = count - done, n = left < PATH_SAMPLES ? left : PATH_SAMPLES;
        if (done > 0 && !path_goes_on(c)) return;
        path_trace(c, &m->block, LENS_SECOND_SET_FIRST + done, n, paths);
        add(c, &paths->radiance, n, m);
        done += n;
    }
    store(m, samples);
}
