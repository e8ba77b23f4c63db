#pragma once
/* For functions of kernels that are fast only inside their callers' loops, where constants are
 * known and numbers stay in registers. */
#define SIMD_INLINE static inline __attribute__((always_inline))
