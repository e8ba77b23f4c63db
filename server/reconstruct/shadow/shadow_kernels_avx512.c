#define SHADOW_KERNELS shadow_kernels_avx512
#include "server/reconstruct/shadow/shadow_kernels_body.h"
