#pragma once
/* What one core of this machine can do at most, with vectors of an instruction set: loops of
 * nothing but additions and multiplications, of fused ones, of divisions, of square roots and of
 * additions of whole numbers, on registers; and how fast numbers come from caches and memory. The
 * best of some turns each, and of what was measured before. */
#include <immintrin.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { ROOF_CHAINS = 12, ROOF_TURNS = 15, ROOF_LOOPS = 20000 };

enum roof_level { ROOF_L2, ROOF_L3, ROOF_MEMORY, ROOF_LEVELS };
static const char *const roof_level_names[ROOF_LEVELS] = {"L2", "L3", "memory"};

struct roof_machine {
    double mul_add, fused;          /* floating-point operations a nanosecond */
    double divisions, roots, whole; /* numbers a nanosecond */
    double slots;                   /* vector instructions a nanosecond: the simplest */
    double loads;                   /* lines of the first cache a nanosecond */
    double stores, narrow; /* vectors of a line that go there, 0 where there are none; others */
    double bandwidth[ROOF_LEVELS];   /* bytes a nanosecond: read, or read and written by a copy */
    size_t cache_bytes[ROOF_MEMORY]; /* of L2 and of L3; one thread's share */
};

static inline double roof_clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static inline double roof_best(double a, double b)
{
    return a > b ? a : b;
}

static volatile float roof_sink, roof_source = 1.0f; /* nothing is known before it runs */

/* ROOF_LOOPS times `step` on as many independent chains as hide what one takes; every number that
 * an instruction works on counts `each`. Numbers a nanosecond. */
#define ROOF_RATE(name, isa, vector, lanes, load, step)                                            \
    __attribute__((target(isa), noinline)) static double name(void)                                \
    {                                                                                              \
        float numbers[ROOF_CHAINS * (lanes)];                                                      \
        const float last = roof_source;                                                            \
        for (int i = 0; i < ROOF_CHAINS * (lanes); i++) numbers[i] = last + 1e-6f * (float)i;      \
        vector a[ROOF_CHAINS], b = load(numbers);                                                  \
        double best = 1e30;                                                                        \
        for (int turn = 0; turn < ROOF_TURNS; turn++) {                                            \
            for (int k = 0; k < ROOF_CHAINS; k++) a[k] = load(numbers + k * (lanes));              \
            const double start = roof_clock_ns();                                                  \
            for (int i = 0; i < ROOF_LOOPS; i++) {                                                 \
                _Pragma("GCC unroll 12") for (int k = 0; k < ROOF_CHAINS; k++) step;               \
                __asm__ volatile("" : "+x"(b)); /* every turn anew */                              \
            }                                                                                      \
            const double took = roof_clock_ns() - start;                                           \
            best = took < best ? took : best;                                                      \
            float out[lanes];                                                                      \
            for (int k = 1; k < ROOF_CHAINS; k++) a[0] += a[k];                                    \
            memcpy(out, &a[0], sizeof out);                                                        \
            roof_sink = out[0];                                                                    \
        }                                                                                          \
        return (double)ROOF_LOOPS * ROOF_CHAINS * (lanes) / best;                                  \
    }

/* The same of additions of whole numbers: where compilers move what they add to, slots are lost. */
#define ROOF_ADD_sse(k)    "paddd %%xmm" #k ", %%xmm" #k "\n"
#define ROOF_ADD_avx2(k)   "vpaddd %%ymm" #k ", %%ymm" #k ", %%ymm" #k "\n"
#define ROOF_ADD_avx512(k) "vpaddd %%zmm" #k ", %%zmm" #k ", %%zmm" #k "\n"
#define ROOF_TWELVE(add)                                                                           \
    add(0) add(1) add(2) add(3) add(4) add(5) add(6) add(7) add(8) add(9) add(10) add(11)
#define ROOF_WHOLE(tier, isa, lanes)                                                               \
    __attribute__((target(isa), noinline)) static double roof_whole_##tier(void)                   \
    {                                                                                              \
        double best = 1e30;                                                                        \
        for (int turn = 0; turn < ROOF_TURNS; turn++) {                                            \
            const double start = roof_clock_ns();                                                  \
            for (int i = 0; i < ROOF_LOOPS; i++)                                                   \
                __asm__ volatile(ROOF_TWELVE(ROOF_ADD_##tier)::                                    \
                                     : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6",     \
                                       "xmm7", "xmm8", "xmm9", "xmm10", "xmm11");                  \
            const double took = roof_clock_ns() - start;                                           \
            best = took < best ? took : best;                                                      \
        }                                                                                          \
        return (double)ROOF_LOOPS * ROOF_CHAINS * (lanes) / best;                                  \
    }

#include "tests/bench/roofline_ports.h"

#define ROOF_TIER(tier, isa, vector, lanes, load, fma_step, root)                                  \
    ROOF_RATE(roof_mul_add_##tier, isa, vector, lanes, load, (k & 1 ? (a[k] += b) : (a[k] *= b)))  \
    ROOF_RATE(roof_fused_##tier, isa, vector, lanes, load, a[k] = fma_step)                        \
    ROOF_RATE(roof_divide_##tier, isa, vector, lanes, load, a[k] = b / a[k])                       \
    ROOF_RATE(roof_root_##tier, isa, vector, lanes, load, a[k] = root(a[k]))                       \
    ROOF_WHOLE(tier, isa, lanes)                                                                   \
    PORTS_RATE(ports_load_##tier, isa, PORTS_LOAD_##tier)                                          \
    static inline void roof_arithmetic_##tier(struct roof_machine *m)                              \
    {                                                                                              \
        m->mul_add = roof_best(m->mul_add, roof_mul_add_##tier());                                 \
        m->fused = roof_best(m->fused, 2.0 * roof_fused_##tier());                                 \
        m->divisions = roof_best(m->divisions, roof_divide_##tier());                              \
        m->roots = roof_best(m->roots, roof_root_##tier());                                        \
        m->whole = roof_best(m->whole, roof_whole_##tier());                                       \
        m->slots = m->whole / (lanes);                                                             \
        m->loads = roof_best(m->loads, ports_load_##tier());                                       \
    }

/* SSE has no fused operation: two. */
ROOF_TIER(sse, "sse4.2", __m128, 4, _mm_loadu_ps, a[k] * b + b, _mm_sqrt_ps)
ROOF_TIER(avx2, "avx2,fma", __m256, 8, _mm256_loadu_ps, _mm256_fmadd_ps(a[k], b, b), _mm256_sqrt_ps)
ROOF_TIER(avx512, "avx512f", __m512, 16, _mm512_loadu_ps, _mm512_fmadd_ps(a[k], b, b),
          _mm512_sqrt_ps)

/* Sums of all numbers, and a copy of one half to the other: bytes that went to or from the core. */
static inline double roof_bandwidth(size_t bytes, int turns)
{
    typedef float wide __attribute__((vector_size(64), may_alias));
    const size_t count = bytes / sizeof(wide), half = count / 2;
    wide *data = aligned_alloc(64, count * sizeof *data), sum[4];
    double best = 1e30;
    if (!data) abort();
    memset(data, 0, count * sizeof *data);
    memset(sum, 0, sizeof sum);
    for (int turn = 0; turn < turns; turn++) {
        const double start = roof_clock_ns();
        for (size_t i = 0; i + 4 <= count; i += 4)
            for (size_t k = 0; k < 4; k++) sum[k] += data[i + k];
        const double read = roof_clock_ns() - start;
        memcpy(data + half, data, half * sizeof *data);
        __asm__ volatile("" : : "r"(data) : "memory");
        const double copied = roof_clock_ns() - start - read;
        best = read < best ? read : best;
        best = copied < best ? copied : best;
    }
    for (int k = 1; k < 4; k++) sum[0] += sum[k];
    roof_sink = sum[0][0];
    free(data);
    return (double)(count * sizeof *data) / best;
}

static inline size_t roof_cache(int name, size_t otherwise)
{
    const long bytes = sysconf(name);
    return bytes > 0 ? (size_t)bytes : otherwise;
}

/* *m: zeros, or what was measured before. */
static inline void roof_measure(const char *isa, struct roof_machine *m)
{
    m->cache_bytes[ROOF_L2] = roof_cache(_SC_LEVEL2_CACHE_SIZE, 512 << 10);
    m->cache_bytes[ROOF_L3] = roof_cache(_SC_LEVEL3_CACHE_SIZE, 8 << 20);
    if (!strcmp(isa, "avx512"))
        roof_arithmetic_avx512(m);
    else if (!strcmp(isa, "avx2"))
        roof_arithmetic_avx2(m);
    else
        roof_arithmetic_sse(m);
    if (!strcmp(isa, "avx512")) m->stores = roof_best(m->stores, ports_store_line());
    m->narrow = roof_best(m->narrow, ports_store_narrow());
    /* Well inside a cache, of L3 little, which others share; and well beyond all. */
    const size_t l2 = m->cache_bytes[ROOF_L2], l3 = m->cache_bytes[ROOF_L3];
    m->bandwidth[ROOF_L2] = roof_best(m->bandwidth[ROOF_L2], roof_bandwidth(l2 / 2, 400));
    m->bandwidth[ROOF_L3] =
        roof_best(m->bandwidth[ROOF_L3], roof_bandwidth(l3 / 4 < 3 * l2 ? l3 / 4 : 3 * l2, 80));
    m->bandwidth[ROOF_MEMORY] = roof_best(m->bandwidth[ROOF_MEMORY], roof_bandwidth(6 * l3, 6));
}
