/* What indirect_kernels are compared with. */
#include "tests/kernel/reference.h"

#define FUSED_BY_LIBRARY
#define INDIRECT_KERNELS indirect_kernels_reference
#include "server/reconstruct/indirect/indirect_kernels_body.h"
