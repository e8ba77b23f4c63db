#define LENS_LIGHT_KERNELS lens_light_kernels_avx2
#include "server/reconstruct/lens_light_kernels_body.h"
