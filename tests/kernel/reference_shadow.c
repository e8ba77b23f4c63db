/* What shadow_kernels are compared with. */
#include "tests/kernel/reference.h"

#define FUSED_BY_LIBRARY
#define SHADOW_KERNELS shadow_kernels_reference
#include "server/reconstruct/shadow/shadow_kernels_body.h"
