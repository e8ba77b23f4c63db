#define LENS_LIGHT_KERNELS lens_light_kernels_avx2
#include "server/reconstruct/lighting/lens_light_kernels_body.h"
