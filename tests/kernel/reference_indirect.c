/* What indirect_kernels are compared with. */
#define FUSED_BY_LIBRARY
#define INDIRECT_KERNELS indirect_kernels_reference
#include "server/reconstruct/indirect_kernels_body.h"
