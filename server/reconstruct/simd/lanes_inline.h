#pragma once
/* Functions of kernels that are only fast inside their callers' loops: where constants are known,
 * and numbers stay in registers. */
#define LANES_INLINE static inline __attribute__((always_inline))
