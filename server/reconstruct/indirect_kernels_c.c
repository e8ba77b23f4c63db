/* The reference: what every other set of kernels is compared with. */
#define INDIRECT_KERNELS indirect_kernels_c
#include "server/reconstruct/indirect_kernels_body.h"
