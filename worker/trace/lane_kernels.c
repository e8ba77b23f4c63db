#define LANE_KERNELS lane_kernels_sse42
#include "worker/trace/lane_kernels_body.h"

#include <string.h>

const struct lane_kernels *lane_kernels_for(const char *isa)
{
    if (strcmp(isa, "avx512") == 0) return &lane_kernels_avx512;
    if (strcmp(isa, "avx2") == 0) return &lane_kernels_avx2;
    return &lane_kernels_sse42;
}
