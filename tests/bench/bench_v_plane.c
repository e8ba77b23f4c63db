/* The sheared filter of indirect light beside brute-force 4D filtering, filtering along the axes
 * and no shear: how much faster, how much worse or better.
 *
 *     bench_v_plane [SPP]
 *
 * On the scenes of formulas that the filter's tests stand on, at 512 lines: a floor below a
 * chequered ceiling at several heights, and a room. Prints one JSON line each: errors over the
 * middle of the picture relative to its mean, CPU time of one thread a pixel, the factored filter's
 * as the median over repetitions. Truth and brute force look at pixels STRIDE apart. */
#include "tests/bench/timing.h"
#include "tests/unit/server/reconstruct/indirect/v_plane_accuracy.h"

#include <stdio.h>

enum { LINES = 512, SIDE_PX = 192, BLOCK_PX = 128, STRIDE = 4, REPETITIONS = 5 };

static struct v_plane_scene scene;

static struct v_plane_picture filter(const struct patch *patch, struct rect rect, double *median_s)
{
    double seconds[REPETITIONS];
    struct v_plane_picture p = {rect, {NULL}};
    for (int i = 0; i < REPETITIONS; i++) {
        picture_fini(&p);
        const double start = cpu_s();
        p = accuracy_filter(&scene, patch, rect, BLOCK_PX, NULL, NULL);
        seconds[i] = cpu_s() - start;
    }
    *median_s = median(seconds, REPETITIONS);
    return p;
}

/* Rule A on the same samples. */
static double axis_aligned(const struct patch *patch, const struct v_plane_picture *truth)
{
    struct plan plan = scene.plan;
    struct indirect_statistics statistics = {0};
    struct v_plane_picture in = accuracy_plain(&scene, patch, patch->rect);
    struct v_plane_picture out = picture_create(patch->rect), part = picture_create(truth->rect);
    const struct rect r = truth->rect;
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    if (indirect_filter(&plan, patch, r, 3, (const float *const *)in.channel, out.channel, NULL,
                        &statistics))
        abort();
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int c = 0; c < 3; c++)
            memcpy(part.channel[c] + picture_index(r, r.x0, y),
                   out.channel[c] + picture_index(patch->rect, r.x0, y),
                   (size_t)rect_width(r) * sizeof(float));
    const double error = accuracy_rmse(truth, &part, truth, STRIDE);
    picture_fini(&part);
    picture_fini(&out);
    picture_fini(&in);
    return error;
}

static void bench(const char *name, uint32_t l)
{
    const int32_t low = (LINES - SIDE_PX) / 2;
    const struct rect rect = {low, low, low + SIDE_PX, low + SIDE_PX};
    const double pixels = (double)rect_area(rect), looked = pixels / (STRIDE * STRIDE);
    double factored_s;
    struct patch *patch = v_plane_patch(&scene, rect_grow(rect, INDIRECT_REACH_MAX_PX), l);
    struct v_plane_picture truth = accuracy_truth(&scene, rect, STRIDE);
    struct v_plane_picture plain = accuracy_plain(&scene, patch, rect);
    struct v_plane_picture factored = filter(patch, rect, &factored_s);
    const double start = cpu_s();
    struct v_plane_picture brute = accuracy_brute(&scene, patch, rect, 1.0f, STRIDE);
    const double brute_s = cpu_s() - start;
    struct v_plane_picture straight = accuracy_brute(&scene, patch, rect, 0.0f, STRIDE);
    const double error = accuracy_rmse(&truth, &factored, &truth, STRIDE);
    const double brute_error = accuracy_rmse(&truth, &brute, &truth, STRIDE);
    printf("{\"scene\": \"%s\", \"spp\": %u, \"average_rmse\": %.5f, \"axis_aligned_rmse\": %.5f, "
           "\"no_shear_rmse\": %.5f, \"factored_rmse\": %.5f, \"brute_rmse\": %.5f, "
           "\"rmse_ratio\": %.4f, \"difference_rmse\": %.5f, \"factored_ns\": %.0f, "
           "\"brute_ns\": %.0f, \"time_ratio\": %.1f}\n",
           name, l * l, accuracy_rmse(&truth, &plain, &truth, STRIDE), axis_aligned(patch, &truth),
           accuracy_rmse(&truth, &straight, &truth, STRIDE), error, brute_error,
           error / brute_error, accuracy_rmse(&truth, &factored, &brute, STRIDE),
           1e9 * factored_s / pixels, 1e9 * brute_s / looked,
           brute_s / looked / (factored_s / pixels));
    fflush(stdout);
    picture_fini(&straight);
    picture_fini(&brute);
    picture_fini(&factored);
    picture_fini(&plain);
    picture_fini(&truth);
    patch_destroy(&patch);
}

int main(int argc, char **argv)
{
    static const float heights[] = {0.05f, 0.1f, 0.15f, 0.3f};
    const long spp = argc > 1 ? strtol(argv[1], NULL, 10) : 9;
    uint32_t l = 1;
    if (spp < 1 || spp > LIMIT_PLANE_STRATA_PER_AXIS * LIMIT_PLANE_STRATA_PER_AXIS) {
        fprintf(stderr, "usage: bench_v_plane [SPP], at most 256\n");
        return 2;
    }
    while ((long)l * l < spp) l++;
    for (size_t i = 0; i < sizeof heights / sizeof *heights; i++) {
        char name[32];
        snprintf(name, sizeof name, "ceiling %.2f", (double)heights[i]);
        v_plane_scene_init(&scene, V_PLANE_CHECKER, LINES, LINES);
        scene.height = heights[i];
        bench(name, l);
    }
    v_plane_scene_init(&scene, V_PLANE_ROOM, LINES, LINES);
    bench("room", l);
    return 0;
}
