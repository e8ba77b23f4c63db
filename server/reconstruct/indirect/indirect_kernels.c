#include "server/reconstruct/indirect/indirect_kernels.h"

#include <string.h>

#include "proto/build.h"

const struct indirect_kernels *indirect_kernels_best(void)
{
    const char *isa = build_isa();
    if (isa && strcmp(isa, "avx512") == 0) return &indirect_kernels_avx512;
    if (isa && strcmp(isa, "avx2") == 0) return &indirect_kernels_avx2;
    return &indirect_kernels_c;
}
