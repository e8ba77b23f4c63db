/* The kernels of what is left of the plain average's difference: every instruction set's give the
 * reference's bits, and the reference's are what its header says. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/lens/lens_residual_kernels.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

enum { COUNT = 61, SAMPLES = 9, PLANES = 15 }; /* no multiple of any vector */

struct numbers {
    float samples[SAMPLES * COUNT], plane[PLANES][COUNT];
};

static struct numbers some(uint32_t state)
{
    struct numbers out;
    float *at = out.samples;
    for (size_t i = 0; i < sizeof out / sizeof(float); i++) {
        state = state * 1664525u + 1013904223u;
        at[i] = (float)(state >> 8) * 0x1p-22f;
    }
    for (size_t i = 0; i < COUNT; i += 3) /* pixels without any difference, darker than others */
        for (int k = 6; k < 9; k++) out.plane[k][i] *= i % 2 ? 0.0f : -0.25f;
    return out;
}

static struct lens_residual_planes planes_of(struct numbers *n)
{
    struct lens_residual_planes out = {
        .found = n->plane[12], .noise = n->plane[13], .own = n->plane[14], .spread = n->plane[11]};
    for (int c = 0; c < 3; c++) {
        out.average[c] = n->plane[c];
        out.picture[c] = n->plane[3 + c];
        out.mean[c] = n->plane[6 + c];
        out.there[c] = n->plane[9 + c];
    }
    return out;
}

/* All kernels, one after the other. */
static void work(const struct lens_residual_kernels *k, struct numbers *n)
{
    const struct lens_residual_planes planes = planes_of(n);
    k->average(n->samples, COUNT, SAMPLES, COUNT, n->plane[0], n->plane[14]);
    k->add(n->plane[4], n->plane[5], COUNT);
    k->divide(n->plane[9], 25.0f, COUNT);
    k->give(&planes, 0.5f, COUNT);
    k->give_own(&planes, 0.125f, 2.0f, SAMPLES, COUNT);
    k->difference(n->plane[1], n->plane[4], COUNT, n->plane[6], n->plane[13]);
    k->square(planes.mean, COUNT, n->plane[12]);
    k->noise(n->plane[12], n->plane[14], n->plane[11], COUNT, n->plane[13]);
}

static void compare(const struct lens_residual_kernels *tested)
{
    for (uint32_t seed = 1; seed < 20; seed++) {
        struct numbers expected = some(seed), result = expected;
        work(&lens_residual_kernels_sse42, &expected);
        work(tested, &result);
        assert_memory_equal(&expected, &result, sizeof result);
    }
}

KERNEL_TESTS(lens_residual, compare)

TEST(averages_are_means_in_order)
{
    struct numbers n = some(7);
    const struct numbers before = n;
    lens_residual_kernels_sse42.average(n.samples, COUNT, SAMPLES, COUNT, n.plane[0], n.plane[14]);
    for (size_t x = 0; x < COUNT; x++) {
        float sum = 0.0f, squares = 0.0f;
        for (size_t j = 0; j < SAMPLES; j++) {
            sum += n.samples[j * COUNT + x];
            squares += n.samples[j * COUNT + x] * n.samples[j * COUNT + x];
        }
        assert_true(n.plane[0][x] == sum / SAMPLES);
        assert_true(n.plane[14][x] == before.plane[14][x] + squares);
    }
}

/* One pixel each: more than noise is given, in part; less is not; nobody falls below what is
 * around; what is already beyond that moves to it. */
TEST(pixels_get_what_is_not_noise)
{
    static const struct {
        float found, noise, mean, there, old, expected;
    } cases[] = {
        {4.0f, 1.0f, 2.0f, 8.0f, 8.0f, 9.0f},  {4.0f, 2.0f, 2.0f, 8.0f, 8.0f, 8.0f},
        {4.0f, 0.0f, -2.0f, 8.0f, 8.0f, 6.0f}, {4.0f, 0.0f, -2.0f, 8.0f, 7.0f, 6.0f},
        {4.0f, 0.0f, -2.0f, 8.0f, 5.0f, 5.0f}, {0.0f, 0.0f, 0.0f, 8.0f, 5.0f, 5.0f},
        {4.0f, 0.0f, 2.0f, 8.0f, 9.0f, 10.0f}, {4.0f, 0.0f, 2.0f, 8.0f, 11.0f, 11.0f},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct numbers n = some(3);
        const struct lens_residual_planes planes = planes_of(&n);
        n.plane[12][0] = cases[k].found;
        n.plane[13][0] = cases[k].noise;
        n.plane[3][0] = cases[k].old;
        n.plane[6][0] = cases[k].mean;
        n.plane[9][0] = cases[k].there;
        lens_residual_kernels_sse42.give(&planes, 2.0f, 1);
        if (!(n.plane[3][0] == cases[k].expected))
            fail_msg("case %zu: %g", k, (double)n.plane[3][0]);
    }
}
