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
#include "tests/kernel/kernel_lens_light.h"
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
    const struct lens_light_kernels *lens_light;
};

static const struct tier tiers[] = {
    {"sse4.2", &shadow_kernels_sse42, &indirect_kernels_sse42, &v_plane_kernels_sse42,
     &glossy_kernels_sse42, &lens_kernels_sse42, &lens_light_kernels_sse42},
    {"avx2", &shadow_kernels_avx2, &indirect_kernels_avx2, &v_plane_kernels_avx2,
     &glossy_kernels_avx2, &lens_kernels_avx2, &lens_light_kernels_avx2},
    {"avx512", &shadow_kernels_avx512, &indirect_kernels_avx512, &v_plane_kernels_avx512,
     &glossy_kernels_avx512, &lens_kernels_avx512, &lens_light_kernels_avx512}};

static uint32_t count_tiers(void)
{
    const char *best = build_isa();
    for (uint32_t i = 0; best && i < 3; i++)
        if (strcmp(tiers[i].name, best) == 0) return i + 1;
    return 1;
}

/* The greatest difference over counts and starts. */
static float compare_field(const struct kernel_field *k, const struct shadow_kernels *tested,
                           enum kernel kernel)
{
    const uint32_t counts[] = {1, 2, 7, 31, 33, 64, k->count};
    float most = 0.0f;
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        const uint32_t count = counts[i] < k->count ? counts[i] : k->count;
        const float d = field_compare(k, tested, kernel, (k->count - count) / 3, count);
        most = d > most ? d : most;
    }
    return most;
}

/* Those of SSE4.2, which are compared on fields without extremes. */
static bool rounds_twice(const struct tier *tier)
{
    return tier->kernels == &shadow_kernels_sse42;
}

static bool is_wild(const struct tier *tier, uint64_t seed)
{
    return !rounds_twice(tier) && seed != 3;
}

/* How far numbers may be off, of the greatest one. */
static float tolerance_of(const struct tier *tier)
{
    return rounds_twice(tier) ? REFERENCE_ROUNDING : 0.0f;
}

static void compare_all(const struct tier *tier, uint32_t l, int *passed, int *failed)
{
    float most[KERNEL_COUNT] = {0};
    for (uint64_t seed = 0; seed < FIELDS; seed++) {
        struct kernel_field k;
        field_init(&k, l, 13 + 4 * (int32_t)seed, 21 - 2 * (int32_t)seed, 977 * l + seed,
                   is_wild(tier, seed));
        for (enum kernel i = 0; i < KERNEL_COUNT; i++) {
            const float d = compare_field(&k, tier->kernels, i);
            most[i] = d > most[i] ? d : most[i];
        }
        field_fini(&k);
    }
    for (enum kernel i = 0; i < KERNEL_COUNT; i++) {
        const bool ok = most[i] <= (rounds_twice(tier) ? field_rounding(i) : 0.0f);
        if (!ok)
            printf("%s, %s, %u strata an axis: off by %g\n", tier->name, kernel_names[i], l,
                   (double)most[i]);
        *(ok ? passed : failed) += 1;
    }
}

static void compare_indirect(const struct tier *tier, int *passed, int *failed)
{
    for (enum indirect_kernel i = 0; i < INDIRECT_KERNEL_COUNT; i++) {
        float most = 0.0f;
        for (uint64_t seed = 0; seed < FIELDS; seed++) {
            struct indirect_case k;
            indirect_case_init(&k, 13 + 9 * (int32_t)seed, 47 - 5 * (int32_t)seed, 31 + seed,
                               is_wild(tier, seed));
            for (int32_t start = 0; start < 12; start += 5)
                most = fmaxf(most, indirect_case_compare(&k, tier->indirect, i, start));
            indirect_case_fini(&k);
        }
        if (most > tolerance_of(tier))
            printf("%s, %s: off by %g\n", tier->name, indirect_kernel_names[i], (double)most);
        *(most <= tolerance_of(tier) ? passed : failed) += 1;
    }
}

static void compare_glossy(const struct tier *tier, int *passed, int *failed)
{
    for (enum glossy_kernel i = 0; i < GLOSSY_KERNEL_COUNT; i++) {
        float most = 0.0f;
        for (uint64_t seed = 0; seed < FIELDS; seed++) {
            struct glossy_case k;
            glossy_case_init(&k, 13 + 9 * (int32_t)seed, 47 - 5 * (int32_t)seed, 71 + seed,
                             is_wild(tier, seed));
            for (int32_t start = 0; start < 12; start += 5)
                most = fmaxf(most, glossy_case_compare(&k, tier->glossy, i, start));
            glossy_case_fini(&k);
        }
        if (most > tolerance_of(tier))
            printf("%s, %s: off by %g\n", tier->name, glossy_kernel_names[i], (double)most);
        *(most <= tolerance_of(tier) ? passed : failed) += 1;
    }
}

/* Cells from four a pixel to one of four pixels. */
static void compare_lens(const struct tier *tier, int *passed, int *failed)
{
    for (enum lens_kernel i = 0; i < LENS_KERNEL_COUNT; i++) {
        float most = 0.0f;
        for (uint64_t seed = 0; seed < FIELDS; seed++) {
            struct lens_case k;
            lens_case_init(&k, 16 + 9 * (int32_t)seed, 23 - 3 * (int32_t)seed, 91 + seed,
                           (int32_t)(seed % 4) - 1);
            most = fmaxf(most, lens_case_compare(&k, tier->lens, i));
            lens_case_fini(&k);
        }
        if (most > 0.0f)
            printf("%s, lens, %s: off by %g\n", tier->name, lens_kernel_names[i], (double)most);
        *(most <= 0.0f ? passed : failed) += 1;
    }
}

static void compare_lens_light(const struct tier *tier, int *passed, int *failed)
{
    for (enum lens_light_kernel i = 0; i < LIT_LENS_KERNEL_COUNT; i++) {
        float most = 0.0f;
        for (uint32_t seed = 0; seed < FIELDS; seed++) {
            struct lens_light_case k;
            lens_light_case_init(&k, 23 + 19 * seed, 17 + seed);
            for (uint32_t first = 0; first < 12; first += 5)
                most = fmaxf(most, lens_light_case_compare(&k, tier->lens_light, i, first));
            lens_light_case_fini(&k);
        }
        if (most > 0.0f)
            printf("%s, light, %s: other bits\n", tier->name, lens_light_kernel_names[i]);
        *(most <= 0.0f ? passed : failed) += 1;
    }
}

static void compare_v_plane(const struct tier *tier, uint32_t l, int *passed, int *failed)
{
    for (enum v_plane_kernel i = 0; i < V_PLANE_KERNEL_COUNT; i++) {
        float most = 0.0f;
        for (uint64_t seed = 0; seed < FIELDS; seed++) {
            struct v_plane_case k;
            v_plane_case_init(&k, l, 1 + 13 * (int32_t)seed, 31 * l + seed, is_wild(tier, seed));
            most = fmaxf(most, v_plane_case_compare(&k, tier->v_plane, i));
            v_plane_case_fini(&k);
        }
        if (most > tolerance_of(tier))
            printf("%s, %s, %u strata an axis: off by %g\n", tier->name, v_plane_kernel_names[i], l,
                   (double)most);
        *(most <= tolerance_of(tier) ? passed : failed) += 1;
    }
}

static double now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* The fastest of some turns, a pixel. */
static double time_kernel(const struct kernel_field *k, const struct tier *tier, enum kernel kernel,
                          double *cycles)
{
    float *out = field_memory(field_output(k, kernel, k->count) * sizeof *out);
    double best = 1e30;
    for (int turn = 0; turn < TIMED_TURNS; turn++) {
        const double start = now_ns();
        const uint64_t ticks = __rdtsc();
        field_run(k, tier->kernels, kernel, 0, k->count, out);
        const double took = now_ns() - start;
        if (took < best) *cycles = (double)(__rdtsc() - ticks) / k->count;
        best = took < best ? took : best;
    }
    free(out);
    return best / k->count;
}

static void time_all(uint32_t tier_count)
{
    struct kernel_field k;
    field_init(&k, 3, TIMED_SIDE, TIMED_SIDE, 4, false);
    printf("%-16s %-8s %10s %10s %9s\n", "kernel", "set", "ns/pixel", "cycles", "speed-up");
    for (enum kernel i = 0; i < KERNEL_COUNT; i++) {
        double first = 0.0;
        for (uint32_t t = 0; t < tier_count; t++) {
            double cycles = 0.0;
            const double ns = time_kernel(&k, &tiers[t], i, &cycles);
            if (t == 0) first = ns;
            printf("%-16s %-8s %10.1f %10.0f %9.2f\n", kernel_names[i], tiers[t].name, ns, cycles,
                   first / ns);
        }
    }
    field_fini(&k);
}

static void time_indirect(uint32_t tier_count)
{
    struct indirect_case k;
    indirect_case_init(&k, TIMED_SIDE, TIMED_SIDE, 4, false);
    float *out = field_memory(INDIRECT_CASE_CHANNELS * k.area * sizeof *out);
    for (enum indirect_kernel i = 0; i < INDIRECT_KERNEL_COUNT; i++) {
        double first = 0.0;
        for (uint32_t t = 0; t < tier_count; t++) {
            double best = 1e30, cycles = 0.0;
            for (int turn = 0; turn < TIMED_TURNS; turn++) {
                const double start = now_ns();
                const uint64_t ticks = __rdtsc();
                indirect_case_run(&k, tiers[t].indirect, i, 0, out);
                const double took = (now_ns() - start) / (TIMED_SIDE * TIMED_SIDE);
                if (took < best) cycles = (double)(__rdtsc() - ticks) / (TIMED_SIDE * TIMED_SIDE);
                best = took < best ? took : best;
            }
            if (t == 0) first = best;
            printf("%-16s %-8s %10.1f %10.0f %9.2f\n", indirect_kernel_names[i], tiers[t].name,
                   best, cycles, first / best);
        }
    }
    free(out);
    indirect_case_fini(&k);
}

static void time_glossy(uint32_t tier_count)
{
    struct glossy_case k;
    glossy_case_init(&k, TIMED_SIDE, TIMED_SIDE, 4, false);
    float *out = field_memory(GLOSSY_CASE_CHANNELS * k.area * sizeof *out);
    for (enum glossy_kernel i = 0; i < GLOSSY_KERNEL_COUNT; i++) {
        double first = 0.0;
        for (uint32_t t = 0; t < tier_count; t++) {
            double best = 1e30, cycles = 0.0;
            for (int turn = 0; turn < TIMED_TURNS; turn++) {
                const double start = now_ns();
                const uint64_t ticks = __rdtsc();
                glossy_case_run(&k, tiers[t].glossy, i, 0, out);
                const double took = (now_ns() - start) / (TIMED_SIDE * TIMED_SIDE);
                if (took < best) cycles = (double)(__rdtsc() - ticks) / (TIMED_SIDE * TIMED_SIDE);
                best = took < best ? took : best;
            }
            if (t == 0) first = best;
            printf("%-16s %-8s %10.1f %10.0f %9.2f\n", glossy_kernel_names[i], tiers[t].name, best,
                   cycles, first / best);
        }
    }
    free(out);
    glossy_case_fini(&k);
}

/* A lens sample, or a pixel that looks at one layer. */
static void time_lens(uint32_t tier_count)
{
    struct lens_case k;
    lens_case_init(&k, TIMED_SIDE, TIMED_SIDE, 5, 0);
    for (enum lens_kernel i = 0; i < LENS_KERNEL_COUNT; i++) {
        float *out = field_memory(lens_case_size(&k, i) * sizeof *out);
        double first = 0.0;
        for (uint32_t t = 0; t < tier_count; t++) {
            double best = 1e30, cycles = 0.0;
            for (int turn = 0; turn < TIMED_TURNS; turn++) {
                const double start = now_ns();
                const uint64_t ticks = __rdtsc();
                lens_case_run(&k, tiers[t].lens, i, out);
                const double took = (now_ns() - start) / (TIMED_SIDE * TIMED_SIDE);
                if (took < best) cycles = (double)(__rdtsc() - ticks) / (TIMED_SIDE * TIMED_SIDE);
                best = took < best ? took : best;
            }
            if (t == 0) first = best;
            printf("lens, %-10s %-8s %10.1f %10.0f %9.2f\n", lens_kernel_names[i], tiers[t].name,
                   best, cycles, first / best);
        }
        free(out);
    }
    lens_case_fini(&k);
}

/* A lens sample. */
static void time_lens_light(uint32_t tier_count)
{
    const uint32_t count = TIMED_SIDE * TIMED_SIDE;
    struct lens_light_case k;
    lens_light_case_init(&k, count, 6);
    float *out = field_memory(lens_light_case_size(&k) * sizeof *out);
    for (enum lens_light_kernel i = 0; i < LIT_LENS_KERNEL_COUNT; i++) {
        double first = 0.0;
        for (uint32_t t = 0; t < tier_count; t++) {
            double best = 1e30, cycles = 0.0;
            for (int turn = 0; turn < TIMED_TURNS; turn++) {
                const double start = now_ns();
                const uint64_t ticks = __rdtsc();
                lens_light_case_run(&k, tiers[t].lens_light, i, 0, out);
                const double took = (now_ns() - start) / count;
                if (took < best) cycles = (double)(__rdtsc() - ticks) / count;
                best = took < best ? took : best;
            }
            if (t == 0) first = best;
            printf("light, %-9s %-8s %10.1f %10.0f %9.2f\n", lens_light_kernel_names[i],
                   tiers[t].name, best, cycles, first / best);
        }
    }
    free(out);
    lens_light_case_fini(&k);
}

/* A pixel at 9 samples. */
static void time_v_plane(uint32_t tier_count)
{
    struct v_plane_case k;
    v_plane_case_init(&k, 3, TIMED_SIDE, 4, false);
    float *out = field_memory(v_plane_case_output(&k) * sizeof *out);
    for (enum v_plane_kernel i = 0; i < V_PLANE_KERNEL_COUNT; i++) {
        double first = 0.0;
        for (uint32_t t = 0; t < tier_count; t++) {
            double best = 1e30, cycles = 0.0;
            for (int turn = 0; turn < TIMED_TURNS; turn++) {
                const double start = now_ns();
                const uint64_t ticks = __rdtsc();
                v_plane_case_run(&k, tiers[t].v_plane, i, out);
                const double took = (now_ns() - start) / TIMED_SIDE;
                if (took < best) cycles = (double)(__rdtsc() - ticks) / TIMED_SIDE;
                best = took < best ? took : best;
            }
            if (t == 0) first = best;
            printf("%-16s %-8s %10.1f %10.0f %9.2f\n", v_plane_kernel_names[i], tiers[t].name, best,
                   cycles, first / best);
        }
    }
    free(out);
    v_plane_case_fini(&k);
}

int main(void)
{
    static const uint32_t strata[] = {1, 2, 3, 4, 5, 7, 8, 11, 16};
    const uint32_t tier_count = count_tiers();
    int passed = 0, failed = 0;
    printf("tolerance: 0; of %s, which rounds products, %g of the greatest number\n", tiers[0].name,
           (double)REFERENCE_ROUNDING);
    for (uint32_t t = 0; t < tier_count; t++) {
        for (size_t i = 0; i < sizeof strata / sizeof *strata; i++)
            compare_all(&tiers[t], strata[i], &passed, &failed);
        for (size_t i = 0; i < sizeof strata / sizeof *strata; i++)
            compare_v_plane(&tiers[t], strata[i], &passed, &failed);
        compare_indirect(&tiers[t], &passed, &failed);
        compare_glossy(&tiers[t], &passed, &failed);
        if (t == 0) continue; /* their own reference: they fuse nothing */
        compare_lens(&tiers[t], &passed, &failed);
        compare_lens_light(&tiers[t], &passed, &failed);
    }
    time_all(tier_count);
    time_indirect(tier_count);
    time_glossy(tier_count);
    time_lens(tier_count);
    time_lens_light(tier_count);
    time_v_plane(tier_count);
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
