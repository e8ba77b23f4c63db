/* What glossy_kernels are compared with. */
#include "tests/kernel/reference.h"

#define FUSED_BY_LIBRARY
#define GLOSSY_KERNELS glossy_kernels_reference
#include "server/reconstruct/glossy/glossy_kernels_body.h"
