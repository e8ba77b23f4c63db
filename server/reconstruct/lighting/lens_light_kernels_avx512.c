#define LENS_LIGHT_KERNELS lens_light_kernels_avx512
#include "server/reconstruct/lighting/lens_light_kernels_body.h"
