/* The factored sheared filter beside brute-force 4D filtering: how much faster, how much worse.
 *
 *     bench_brute [SPP]
 *
 * On the scene of formulas that the filter's tests stand on, both kinds of emission. Prints one
 * JSON line each: errors over penumbra pixels relative to the brightest unshadowed irradiance, CPU
 * seconds of one thread, the factored filter's as the median over repetitions, with its skipping.
 */
#include "tests/bench/timing.h"
#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"

#include <stdio.h>

enum { SIDE_PX = 256, BLOCK_PX = 64, REPETITIONS = 5 };

static struct shadow_scene scene;

/* The filtered picture; *median_s: of the filter alone. */
static float *filter(const struct patch *patch, double *median_s)
{
    double seconds[REPETITIONS];
    float *e = NULL;
    for (int i = 0; i < REPETITIONS; i++) {
        free(e);
        const double start = cpu_s();
        e = accuracy_filter(&scene, patch, SHADOW_FILTER_SHEARED, BLOCK_PX, NULL);
        seconds[i] = cpu_s() - start;
    }
    *median_s = median(seconds, REPETITIONS);
    return e;
}

static void bench(uint32_t profile, uint32_t l)
{
    struct shadow_truth truth;
    double factored_s;
    scene_init(&scene, SIDE_PX, SIDE_PX, 1.0f, 3);
    scene_furnish(&scene);
    scene.plan.lights[0].profile = profile;
    truth_init(&truth, &scene);
    struct patch *patch = accuracy_patch(&scene, l);
    float *factored = filter(patch, &factored_s);
    const double start = cpu_s();
    float *brute = accuracy_brute(&scene, patch, &truth, factored);
    const double brute_s = cpu_s() - start;
    const double error = truth_rmse(&truth, factored, truth.irradiance);
    const double brute_error = truth_rmse(&truth, brute, truth.irradiance);
    printf("{\"profile\": \"%s\", \"spp\": %u, \"side_px\": %d, \"average_rmse\": %.5f, "
           "\"factored_rmse\": %.5f, \"brute_rmse\": %.5f, \"rmse_ratio\": %.4f, "
           "\"difference_rmse\": %.5f, \"factored_s\": %.4f, \"brute_s\": %.3f, "
           "\"time_ratio\": %.1f}\n",
           profile == PROFILE_GAUSSIAN ? "gaussian" : "uniform", l * l, SIDE_PX,
           truth_rmse(&truth, patch->lights[0].irradiance, truth.irradiance), error, brute_error,
           error / brute_error, truth_rmse(&truth, factored, brute), factored_s, brute_s,
           brute_s / factored_s);
    free(brute);
    free(factored);
    patch_destroy(&patch);
    truth_fini(&truth);
}

int main(int argc, char **argv)
{
    const long spp = argc > 1 ? strtol(argv[1], NULL, 10) : 9;
    uint32_t l = 1;
    if (spp < 1 || spp > LIMIT_PLANE_STRATA_PER_AXIS * LIMIT_PLANE_STRATA_PER_AXIS) {
        fprintf(stderr, "usage: bench_brute [SPP], at most 256\n");
        return 2;
    }
    while ((long)l * l < spp) l++;
    bench(PROFILE_GAUSSIAN, l);
    bench(PROFILE_UNIFORM, l);
    return 0;
}
