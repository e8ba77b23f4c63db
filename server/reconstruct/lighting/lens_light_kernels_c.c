/* The reference: what every other set of kernels is compared with. */
#define LENS_LIGHT_KERNELS lens_light_kernels_c
#include "server/reconstruct/lighting/lens_light_kernels_body.h"
