#include "server/reconstruct/glossy/glossy_kernels.h"

#include <string.h>

#include "proto/build.h"

const struct glossy_kernels *glossy_kernels_best(void)
{
    const char *isa = build_isa();
    if (isa && strcmp(isa, "avx512") == 0) return &glossy_kernels_avx512;
    if (isa && strcmp(isa, "avx2") == 0) return &glossy_kernels_avx2;
    return &glossy_kernels_c;
}
