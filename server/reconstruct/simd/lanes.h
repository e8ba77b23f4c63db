#pragma once
/* Pixels that kernels work on side by side, whatever the instruction set. Arrays are padded to a
 * multiple of it. */
#define SIMD_LANES 16
