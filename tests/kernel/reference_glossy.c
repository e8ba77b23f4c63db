/* What glossy_kernels are compared with. */
#include "tests/kernel/reference.h"

#define FUSED_BY_LIBRARY
#define ISA reference
#include "server/reconstruct/glossy/glossy_kernels.c"
