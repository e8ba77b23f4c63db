/* The sheared filter of lens samples beside the sum over picture and lens that it stands for: how
 * much faster, how much worse.
 *
 *     bench_lens_brute [SPP]
 *
 * On the light fields of formulas that the filter's tests stand on. Prints one JSON line each:
 * errors over all pixels relative to the picture's mean, CPU seconds of one thread, the filter's as
 * the median over repetitions. */
#include "tests/bench/timing.h"
#include "tests/unit/server/reconstruct/lens/lens_brute.h"

#include <stdio.h>
#include <stdlib.h>

enum { REPETITIONS = 5, SPP_MAX = 256 };

static int filter(struct lens_picture *p, uint32_t kind, double *median_s)
{
    double seconds[REPETITIONS];
    struct lens_statistics statistics;
    int error = 0;
    for (int i = 0; i < REPETITIONS && !error; i++) {
        const double start = cpu_s();
        error = lens_run(p, kind, &statistics);
        seconds[i] = cpu_s() - start;
    }
    *median_s = median(seconds, REPETITIONS);
    return error;
}

/* Root of the mean squared difference between the picture and `other`, over the reference's mean.
 */
static double difference(const struct lens_picture *p, const float *other, const float *reference)
{
    const size_t count = (size_t)3 * LENS_SIDE * LENS_SIDE;
    double sum = 0.0, mean = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double d = (double)p->out[0][i] - (double)other[i];
        sum += d * d;
        mean += (double)reference[i];
    }
    return sqrt(sum * (double)count) / mean;
}

static int bench(enum lens_scene scene, uint32_t l)
{
    float *reference = lens_reference(scene, 0), factored[3 * LENS_SIDE * LENS_SIDE];
    struct lens_picture p;
    double factored_s = 0.0, plain_s = 0.0;
    lens_picture_create(scene, l, 0, &p);
    int error = filter(&p, LENS_FILTER_NONE, &plain_s);
    const double average = lens_error_of(&p, reference).all;
    if (!error) error = filter(&p, LENS_FILTER_SHEARED, &factored_s);
    const double rmse = lens_error_of(&p, reference).all;
    memcpy(factored, p.out[0], sizeof factored);
    const double start = cpu_s();
    if (!error) error = lens_brute(&p);
    const double brute_s = cpu_s() - start, brute = lens_error_of(&p, reference).all;
    if (!error)
        printf("{\"scene\": \"%s\", \"spp\": %u, \"side_px\": %d, \"average_rmse\": %.5f, "
               "\"factored_rmse\": %.5f, \"brute_rmse\": %.5f, \"rmse_ratio\": %.4f, "
               "\"difference_rmse\": %.5f, \"factored_s\": %.4f, \"brute_s\": %.3f, "
               "\"time_ratio\": %.1f}\n",
               lens_scene_names[scene], l * l, LENS_SIDE, average, rmse, brute, rmse / brute,
               difference(&p, factored, reference), factored_s, brute_s, brute_s / factored_s);
    lens_picture_destroy(&p);
    free(reference);
    return error;
}

int main(int argc, char **argv)
{
    const long spp = argc > 1 ? strtol(argv[1], NULL, 10) : 9;
    uint32_t l = 1;
    if (spp < 1 || spp > SPP_MAX) {
        fprintf(stderr, "usage: bench_lens_brute [SPP], at most %d\n", SPP_MAX);
        return 2;
    }
    while ((long)l * l < spp) l++;
    for (int scene = 0; scene < LENS_SCENES; scene++)
        if (bench((enum lens_scene)scene, l)) return 1;
    return 0;
}
