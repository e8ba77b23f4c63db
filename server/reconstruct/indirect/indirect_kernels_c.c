/* SSE4.2: runs anywhere. */
#define INDIRECT_KERNELS indirect_kernels_c
#include "server/reconstruct/indirect/indirect_kernels_body.h"
