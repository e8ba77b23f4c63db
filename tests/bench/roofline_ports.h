#pragma once
/* How many lines one core reads from its first cache in a nanosecond, and how many vectors it
 * writes there, of a whole line and narrower ones that follow each other: loops of nothing else.
 * Included by roofline_machine.h only. */

enum { PORTS_LOOPS = 100000 };

#define PORTS_EACH(access)                                                                         \
    access(0) access(1) access(2) access(3) access(4) access(5) access(6) access(7) access(8)      \
        access(9) access(10) access(11) access(12) access(13) access(14) access(15)
#define PORTS_LOAD_sse(n)     "movups " #n "*64(%0), %%xmm0\n"
#define PORTS_LOAD_avx2(n)    "vmovups " #n "*64(%0), %%ymm0\n"
#define PORTS_LOAD_avx512(n)  "vmovups " #n "*64(%0), %%zmm0\n"
#define PORTS_STORE_narrow(n) "movups %%xmm0, " #n "*16(%0)\n"
#define PORTS_STORE_line(n)   "vmovups %%zmm0, " #n "*64(%0)\n"

#define PORTS_RATE(name, isa, access)                                                              \
    __attribute__((target(isa), noinline)) static double name(void)                                \
    {                                                                                              \
        static _Alignas(64) char lines[16 * 64];                                                   \
        double best = 1e30;                                                                        \
        for (int turn = 0; turn < ROOF_TURNS; turn++) {                                            \
            const double start = roof_clock_ns();                                                  \
            for (int i = 0; i < PORTS_LOOPS; i++)                                                  \
                __asm__ volatile(PORTS_EACH(access)::"r"(lines) : "xmm0", "memory");               \
            const double took = roof_clock_ns() - start;                                           \
            best = took < best ? took : best;                                                      \
        }                                                                                          \
        return (double)PORTS_LOOPS * 16 / best;                                                    \
    }

PORTS_RATE(ports_store_narrow, "sse4.2", PORTS_STORE_narrow)
PORTS_RATE(ports_store_line, "avx512f", PORTS_STORE_line)
