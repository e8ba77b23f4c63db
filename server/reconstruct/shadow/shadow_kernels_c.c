/* SSE4.2: runs anywhere. */
#define SHADOW_KERNELS shadow_kernels_c
#include "server/reconstruct/shadow/shadow_kernels_body.h"
