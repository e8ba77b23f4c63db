/* The reference: what every other set of kernels is compared with. */
#define LENS_RESIDUAL_KERNELS lens_residual_kernels_c
#include "server/reconstruct/lens/lens_residual_kernels_body.h"
