/* make check-kernels: the kernels of the filters of shadows, of indirect light, of glossy lobes and
 * of lens samples and their light of every instruction set that the CPU has against the reference,
 * on random fields of odd sizes and unaligned input; then what a pixel costs, at 9 samples a light,
 * three channels of indirect light filtered at rule A's widest of 16 samples and 512 lines, and
 * glossy lobes of as many samples. The last line counts.
 *
 * The tolerance is 0, but for SSE4.2, which rounds products that others fuse. Cycles are those of
 * the time stamp counter. */
#include <stdio.h>
#include <time.h>
#include <x86intrin.h>

#include "proto/runtime/build.h"
#include "tests/kernel/kernel_glossy.h"
#include "tests/kernel/kernel_indirect.h"
#include "tests/kernel/kernel_lens.h"
#include "tests/kernel/kernel_lens_relight.h"
#include "tests/kernel/kernel_v_plane.h"

#define FIELDS      6
#define TIMED_SIDE  96
#define TIMED_TURNS 12

struct tier {
    const char *name;
    const struct shadow_kernels *kernels;
    const struct indirect_kernels *indirect;
    const struct v_plane_kernels *v_plane;
    const struct glossy_kernels *glossy;
    const struct lens_kernels *lens;
    const struct lens_relight_kernels *lens_relight;
};

static const struct tier tiers[] = {
    {"sse4.2", &shadow_kernels_sse42, &indirect_kernels_sse42, &v_plane_kernels_sse42,
     &glossy_kernels_sse42, &lens_kernels_sse42, &lens_relight_kernels_sse42},
    {"avx2", &shadow_kernels_avx2, &indirect_kernels_avx2, &v_plane_kernels_avx2,
     &glossy_kernels_avx2, &lens_kernels_avx2, &lens_relight_kernels_avx2},
    {"avx512", &shadow_kernels_avx512, &indirect_kernels_avx512, &v_plane_kernels_avx512,
     &glossy_kernels_avx512, &lens_kernels_avx512, &lens_relight_kernels_avx512}};

static uint32_t count_tiers(void)
{
    const char *best = build_isa();
    for (uint32_t i = 0; best && i < 3; i++)
        if (strcmp(tiers[i].name, best) == 0) return i + 1;
    return 1;
}

/* Those of SSE4.2 round products twice. They are compared on fields without extremes. */
static bool rounds_twice(const struct tier *tier)
{
    return tier->kernels == &shadow_kernels_sse42;
}

static bool is_wild(const struct tier *tier, uint64_t seed)
{
    return !rounds_twice(tier) && seed != 3;
}

/* Compares all kernels of a filter on one field at l x l strata. Raises `most` of each to its
 * greatest difference. */
typedef void compare_fn(const struct tier *tier, uint32_t l, uint64_t seed, float *most);

static void compare_shadow(const struct tier *tier, uint32_t l, uint64_t seed, float *most)
{
    struct kernel_field k;
    field_init(&k, l, 13 + 4 * (int32_t)seed, 21 - 2 * (int32_t)seed, 977 * l + seed,
               is_wild(tier, seed));
    const uint32_t counts[] = {1, 2, 7, 31, 33, 64, k.count};
    for (enum kernel i = 0; i < KERNEL_COUNT; i++)
        for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
            const uint32_t count = counts[n] < k.count ? counts[n] : k.count;
            most[i] =
                fmaxf(most[i], field_compare(&k, tier->kernels, i, (k.count - count) / 3, count));
        }
    field_fini(&k);
}

static void compare_v_plane(const struct tier *tier, uint32_t l, uint64_t seed, float *most)
{
    struct v_plane_case k;
    v_plane_case_init(&k, l, 1 + 13 * (int32_t)seed, 31 * l + seed, is_wild(tier, seed));
    for (enum v_plane_kernel i = 0; i < V_PLANE_KERNEL_COUNT; i++)
        most[i] = fmaxf(most[i], v_plane_case_compare(&k, tier->v_plane, i));
    v_plane_case_fini(&k);
}

static void compare_indirect(const struct tier *tier, uint32_t l, uint64_t seed, float *most)
{
    (void)l;
    struct indirect_case k;
    indirect_case_init(&k, 13 + 9 * (int32_t)seed, 47 - 5 * (int32_t)seed, 31 + seed,
                       is_wild(tier, seed));
    for (enum indirect_kernel i = 0; i < INDIRECT_KERNEL_COUNT; i++)
        for (int32_t start = 0; start < 12; start += 5)
            most[i] = fmaxf(most[i], indirect_case_compare(&k, tier->indirect, i, start));
    indirect_case_fini(&k);
}

static void compare_glossy(const struct tier *tier, uint32_t l, uint64_t seed, float *most)
{
    (void)l;
    struct glossy_case k;
    glossy_case_init(&k, 13 + 9 * (int32_t)seed, 47 - 5 * (int32_t)seed, 71 + seed,
                     is_wild(tier, seed));
    for (uint32_t i = 0; i < GLOSSY_KERNEL_COUNT; i++)
        for (int32_t start = 0; start < 12; start += 5)
            most[i] = fmaxf(most[i], glossy_case_compare(&k, tier->glossy, i, start));
    glossy_case_fini(&k);
}

/* Cells from four a pixel to one of four pixels. */
static void compare_lens(const struct tier *tier, uint32_t l, uint64_t seed, float *most)
{
    (void)l;
    struct lens_case k;
    lens_case_init(&k, 16 + 9 * (int32_t)seed, 23 - 3 * (int32_t)seed, 91 + seed,
                   (int32_t)(seed % 4) - 1);
    for (enum lens_kernel i = 0; i < LENS_KERNEL_COUNT; i++)
        most[i] = fmaxf(most[i], lens_case_compare(&k, tier->lens, i));
    lens_case_fini(&k);
}

static void compare_lens_relight(const struct tier *tier, uint32_t l, uint64_t seed, float *most)
{
    (void)l;
    struct lens_relight_case k;
    lens_relight_case_init(&k, 23 + 19 * (uint32_t)seed, 17 + seed);
    for (enum lens_relight_kernel i = 0; i < LIT_LENS_KERNEL_COUNT; i++)
        for (uint32_t first = 0; first < 12; first += 5)
            most[i] = fmaxf(most[i], lens_relight_case_compare(&k, tier->lens_relight, i, first));
    lens_relight_case_fini(&k);
}

static double now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

typedef void run_fn(const void *k, const struct tier *tier, uint32_t kernel, float *out);

/* Prints for each kernel and tier the fastest of some turns over `pixels` pixels. */
static void time_kernels(const void *k, run_fn *run, const char *const *names, uint32_t count,
                         size_t output, double pixels)
{
    float *out = field_memory(output * sizeof *out);
    for (uint32_t i = 0; i < count; i++) {
        double first = 0.0;
        for (uint32_t t = 0; t < count_tiers(); t++) {
            double best = 1e30, cycles = 0.0;
            for (int turn = 0; turn < TIMED_TURNS; turn++) {
                const double start = now_ns();
                const uint64_t ticks = __rdtsc();
                run(k, &tiers[t], i, out);
                const double took = (now_ns() - start) / pixels;
                if (took < best) cycles = (double)(__rdtsc() - ticks) / pixels;
                best = took < best ? took : best;
            }
            if (t == 0) first = best;
            printf("%-16s %-8s %10.1f %10.0f %9.2f\n", names[i], tiers[t].name, best, cycles,
                   first / best);
        }
    }
    free(out);
}

static void run_shadow(const void *k, const struct tier *tier, uint32_t kernel, float *out)
{
    const struct kernel_field *field = k;
    field_run(field, tier->kernels, kernel, 0, field->count, out);
}

static void time_shadow(void)
{
    struct kernel_field k;
    size_t output = 0;
    field_init(&k, 3, TIMED_SIDE, TIMED_SIDE, 4, false);
    for (enum kernel i = 0; i < KERNEL_COUNT; i++)
        if (field_output(&k, i, k.count) > output) output = field_output(&k, i, k.count);
    time_kernels(&k, run_shadow, kernel_names, KERNEL_COUNT, output, k.count);
    field_fini(&k);
}

static void run_indirect(const void *k, const struct tier *tier, uint32_t kernel, float *out)
{
    indirect_case_run(k, tier->indirect, kernel, 0, out);
}

static void time_indirect(void)
{
    struct indirect_case k;
    indirect_case_init(&k, TIMED_SIDE, TIMED_SIDE, 4, false);
    time_kernels(&k, run_indirect, indirect_kernel_names, INDIRECT_KERNEL_COUNT,
                 INDIRECT_CASE_CHANNELS * k.area, TIMED_SIDE * TIMED_SIDE);
    indirect_case_fini(&k);
}

static void run_glossy(const void *k, const struct tier *tier, uint32_t kernel, float *out)
{
    glossy_case_run(k, tier->glossy, kernel, 0, out);
}

static void time_glossy(void)
{
    struct glossy_case k;
    glossy_case_init(&k, TIMED_SIDE, TIMED_SIDE, 4, false);
    time_kernels(&k, run_glossy, glossy_kernel_names, GLOSSY_KERNEL_COUNT,
                 GLOSSY_CASE_CHANNELS * k.area, TIMED_SIDE * TIMED_SIDE);
    glossy_case_fini(&k);
}

static void run_lens(const void *k, const struct tier *tier, uint32_t kernel, float *out)
{
    lens_case_run(k, tier->lens, kernel, out);
}

/* A lens sample, or a pixel that looks at one layer. */
static void time_lens(void)
{
    struct lens_case k;
    lens_case_init(&k, TIMED_SIDE, TIMED_SIDE, 5, 0);
    const size_t gather = lens_case_size(&k, LENS_GATHER), add = lens_case_size(&k, LENS_ADD);
    time_kernels(&k, run_lens, lens_kernel_names, LENS_KERNEL_COUNT, gather > add ? gather : add,
                 TIMED_SIDE * TIMED_SIDE);
    lens_case_fini(&k);
}

static void run_lens_relight(const void *k, const struct tier *tier, uint32_t kernel, float *out)
{
    lens_relight_case_run(k, tier->lens_relight, kernel, 0, out);
}

/* A lens sample. */
static void time_lens_relight(void)
{
    struct lens_relight_case k;
    lens_relight_case_init(&k, TIMED_SIDE * TIMED_SIDE, 6);
    time_kernels(&k, run_lens_relight, lens_relight_kernel_names, LIT_LENS_KERNEL_COUNT,
                 lens_relight_case_size(&k), TIMED_SIDE * TIMED_SIDE);
    lens_relight_case_fini(&k);
}

static void run_v_plane(const void *k, const struct tier *tier, uint32_t kernel, float *out)
{
    v_plane_case_run(k, tier->v_plane, kernel, out);
}

/* A pixel at 9 samples. */
static void time_v_plane(void)
{
    struct v_plane_case k;
    v_plane_case_init(&k, 3, TIMED_SIDE, 4, false);
    time_kernels(&k, run_v_plane, v_plane_kernel_names, V_PLANE_KERNEL_COUNT,
                 v_plane_case_output(&k), TIMED_SIDE);
    v_plane_case_fini(&k);
}

/* The kernels of a filter. */
struct family {
    const char *const *names;
    uint32_t count;
    bool has_strata; /* they are compared at several numbers of strata */
    bool never_fuse; /* those of SSE4.2 are the reference */
    compare_fn *compare;
    void (*time)(void);
};

static const struct family families[] = {
    {kernel_names, KERNEL_COUNT, true, false, compare_shadow, time_shadow},
    {v_plane_kernel_names, V_PLANE_KERNEL_COUNT, true, false, compare_v_plane, time_v_plane},
    {indirect_kernel_names, INDIRECT_KERNEL_COUNT, false, false, compare_indirect, time_indirect},
    {glossy_kernel_names, GLOSSY_KERNEL_COUNT, false, false, compare_glossy, time_glossy},
    {lens_kernel_names, LENS_KERNEL_COUNT, false, true, compare_lens, time_lens},
    {lens_relight_kernel_names, LIT_LENS_KERNEL_COUNT, false, true, compare_lens_relight,
     time_lens_relight},
};

#define FAMILY_COUNT (sizeof families / sizeof *families)

/* How far a kernel's numbers may be off, of the greatest one. */
static float tolerance_of(const struct tier *tier, const struct family *f, uint32_t kernel)
{
    if (!rounds_twice(tier)) return 0.0f;
    return f->names == kernel_names ? field_rounding(kernel) : REFERENCE_ROUNDING;
}

static void compare_family(const struct tier *tier, const struct family *f, uint32_t l, int *passed,
                           int *failed)
{
    float most[KERNEL_COUNT] = {0};
    for (uint64_t seed = 0; seed < FIELDS; seed++) f->compare(tier, l, seed, most);
    for (uint32_t i = 0; i < f->count; i++) {
        const bool ok = most[i] <= tolerance_of(tier, f, i);
        if (!ok)
            printf("%s, %s, %u strata an axis: off by %g\n", tier->name, f->names[i], l,
                   (double)most[i]);
        *(ok ? passed : failed) += 1;
    }
}

int main(void)
{
    static const uint32_t strata[] = {1, 2, 3, 4, 5, 7, 8, 11, 16};
    int passed = 0, failed = 0;
    printf("tolerance: 0; of %s, which rounds products, %g of the greatest number\n", tiers[0].name,
           (double)REFERENCE_ROUNDING);
    for (uint32_t t = 0; t < count_tiers(); t++)
        for (size_t f = 0; f < FAMILY_COUNT; f++) {
            if (families[f].never_fuse && t == 0) continue;
            const size_t most = families[f].has_strata ? sizeof strata / sizeof *strata : 1;
            for (size_t i = 0; i < most; i++)
                compare_family(&tiers[t], &families[f], strata[i], &passed, &failed);
        }
    printf("%-16s %-8s %10s %10s %9s\n", "kernel", "set", "ns/pixel", "cycles", "speed-up");
    for (size_t f = 0; f < FAMILY_COUNT; f++) families[f].time();
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
