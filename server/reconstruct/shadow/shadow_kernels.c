#include "server/reconstruct/shadow/shadow_kernels.h"

#include <string.h>

#include "proto/build.h"

const struct shadow_kernels *shadow_kernels_best(void)
{
    const char *isa = build_isa();
    if (isa && strcmp(isa, "avx512") == 0) return &shadow_kernels_avx512;
    if (isa && strcmp(isa, "avx2") == 0) return &shadow_kernels_avx2;
    return &shadow_kernels_c;
}
