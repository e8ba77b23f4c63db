#define INDIRECT_KERNELS indirect_kernels_avx512
#include "server/reconstruct/indirect/indirect_kernels_body.h"
