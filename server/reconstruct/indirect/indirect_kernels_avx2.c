#define INDIRECT_KERNELS indirect_kernels_avx2
#include "server/reconstruct/indirect/indirect_kernels_body.h"
