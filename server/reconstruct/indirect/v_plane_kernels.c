#include "server/reconstruct/indirect/v_plane_kernels.h"

#include <string.h>

#include "proto/build.h"

const struct v_plane_kernels *v_plane_kernels_best(void)
{
    const char *isa = build_isa();
    if (isa && strcmp(isa, "avx512") == 0) return &v_plane_kernels_avx512;
    if (isa && strcmp(isa, "avx2") == 0) return &v_plane_kernels_avx2;
    return &v_plane_kernels_c;
}
