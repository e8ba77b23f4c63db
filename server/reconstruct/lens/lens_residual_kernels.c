#include "server/reconstruct/lens/lens_residual_kernels.h"

#include <string.h>

#include "proto/build.h"

const struct lens_residual_kernels *lens_residual_kernels_best(void)
{
    const char *isa = build_isa();
    if (isa && strcmp(isa, "avx512") == 0) return &lens_residual_kernels_avx512;
    if (isa && strcmp(isa, "avx2") == 0) return &lens_residual_kernels_avx2;
    return &lens_residual_kernels_c;
}
