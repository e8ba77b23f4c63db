#include "server/reconstruct/lighting/lens_light_kernels.h"

#include <string.h>

#include "proto/build.h"

const struct lens_light_kernels *lens_light_kernels_best(void)
{
    const char *isa = build_isa();
    if (isa && strcmp(isa, "avx512") == 0) return &lens_light_kernels_avx512;
    if (isa && strcmp(isa, "avx2") == 0) return &lens_light_kernels_avx2;
    return &lens_light_kernels_c;
}
