#define LENS_KERNELS lens_kernels_avx2
#include "server/reconstruct/lens/lens_kernels_body.h"
