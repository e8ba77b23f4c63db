#pragma once
/* A picture whose tiles err as rounds expect it, or by another power: for test_rounds and
 * test_rounds_foresee. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/frame/rounds.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

#define TILES 64 /* of a picture of 256 x 256 in tiles of 32 */

/* A picture whose tiles err differently: squared errors of one sample, a pixel. */
struct world {
    struct plan plan;
    struct rounds *rounds;
    double paths[TILES], bounces[TILES]; /* of one sample */
    double fixed;
    double power; /* of samples, with which squared errors truly fall; 0: as rounds expect it */
    double luminance;
    uint32_t n[TILES][2]; /* paths and bounce rays so far */
    uint32_t passes[TILES], more[TILES];
    struct rounds_error errors[TILES];
};

static inline void begin(struct world *w, float target, uint32_t most)
{
    *w = (struct world){.luminance = 0.5};
    synthetic_target_plan(&w->plan, 256, 256, 32, target);
    w->plan.spp_max = most;
    assert_int_equal(rounds_create(&w->plan, &w->rounds), 0);
    for (uint32_t t = 0; t < TILES; t++) {
        w->n[t][0] = w->n[t][1] = 9;
        w->passes[t] = plan_pass_count(&w->plan);
        w->paths[t] = 0.001 * pow(1.17, t % 30);
        w->bounces[t] = t % 4 == 0 ? 0.002 : 0.00001;
    }
}

static inline void measure(struct world *w)
{
    for (uint32_t t = 0; t < TILES; t++) {
        const bool filtered = w->plan.residual_filter != RESIDUAL_FILTER_NONE;
        const double power = w->power > 0 ? w->power : filtered ? 2.0 / 3 : 1.0;
        w->errors[t].variance[ERROR_SOURCE_PATHS] = 1024 * w->paths[t] / pow(w->n[t][0], power);
        /* what bounce rays lower, of diffuse surfaces and of glossy lobes */
        const double square = 1024 * w->bounces[t] / pow(w->n[t][1], 2.0 / 3);
        w->errors[t].variance[ERROR_SOURCE_BOUNCES] = (t % 3) * 0.5 * square;
        w->errors[t].variance[ERROR_SOURCE_LOBES] = (1 - (t % 3) * 0.5) * square;
        w->errors[t].variance[ERROR_SOURCE_CENTRES] = 1024 * w->fixed;
        w->errors[t].luminance = 1024 * w->luminance;
    }
}

static inline double error_of(const struct world *w)
{
    double sum = 0;
    for (uint32_t t = 0; t < TILES; t++)
        for (int s = 0; s < ERROR_SOURCE_COUNT; s++) sum += w->errors[t].variance[s];
    return sqrt(sum / 65536) / w->luminance;
}

/* Traces what a round asks for, and checks that it can. */
static inline void trace(struct world *w)
{
    for (uint32_t t = 0; t < TILES; t++) {
        uint32_t paths = 0, bounces = 0;
        for (uint32_t p = 0; p < w->more[t]; p++) {
            const struct plan_pass pass = rounds_pass(w->rounds, t, w->passes[t] + p);
            assert_int_equal(pass.number, w->passes[t] + p);
            assert_int_equal(plan_pass_check(&w->plan, &pass), 0);
            if (pass.count > 0) assert_int_equal(pass.first, w->n[t][0] + paths);
            paths += pass.count;
            bounces += pass.strata * pass.strata;
        }
        assert_true(paths <= 3 * w->n[t][0] + w->n[t][0] / 4 + 4);
        assert_true(bounces <= 3 * w->n[t][1] + 64);
        w->n[t][0] += paths;
        w->n[t][1] += bounces;
        w->passes[t] += w->more[t];
        assert_true(w->n[t][0] <= w->plan.spp_max && w->n[t][1] <= w->plan.spp_max);
    }
}

static inline double samples_of(const struct world *w)
{
    double sum = 0;
    for (uint32_t t = 0; t < TILES; t++) sum += 1024.0 * (w->n[t][0] + w->n[t][1]);
    return sum;
}
