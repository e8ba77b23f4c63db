/* The reference: what every other set of kernels is compared with. */
#define SHADOW_KERNELS shadow_kernels_c
#include "server/reconstruct/shadow_kernels_body.h"
