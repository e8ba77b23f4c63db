#define LENS_RESIDUAL_KERNELS lens_residual_kernels_avx2
#include "server/reconstruct/lens/lens_residual_kernels_body.h"
