#include "proto/runtime/kernels.h"

#include <string.h>

const void *kernels_for(const char *isa, const void *sse42, const void *avx2, const void *avx512)
{
    if (isa && strcmp(isa, "avx512") == 0) return avx512;
    return isa && strcmp(isa, "avx2") == 0 ? avx2 : sse42;
}
