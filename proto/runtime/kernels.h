#pragma once
/* Tables of kernels: inner loops, compiled once for each instruction set that build_isa() names. A
 * table `struct X` is defined as KERNELS(X) in a source X.c, which the Makefile compiles three
 * times, with ISA defined as sse42, avx2 and avx512: X_sse42 runs on every CPU. */
#include "proto/runtime/build.h"

#define KERNELS_JOINED(name, isa) name##_##isa
#define KERNELS_OF(name, isa)     KERNELS_JOINED(name, isa)
#define KERNELS(name)             KERNELS_OF(name, ISA)

/* Returns the table to use with an instruction set that build_isa() names; NULL counts as
 * SSE4.2. */
#define KERNELS_FOR(name, isa)                                                                     \
    ((const struct name *)kernels_for(isa, &name##_sse42, &name##_avx2, &name##_avx512))

/* Returns the table to use on this CPU. */
#define KERNELS_BEST(name) KERNELS_FOR(name, build_isa())

/* Returns one of the three. */
const void *kernels_for(const char *isa, const void *sse42, const void *avx2, const void *avx512);
