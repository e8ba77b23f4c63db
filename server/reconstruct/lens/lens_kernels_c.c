/* The reference: what every other set of kernels is compared with. */
#define LENS_KERNELS lens_kernels_c
#include "server/reconstruct/lens/lens_kernels_body.h"
