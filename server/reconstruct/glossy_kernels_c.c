/* The reference: what every other set of kernels is compared with. */
#define GLOSSY_KERNELS glossy_kernels_c
#include "server/reconstruct/glossy_kernels_body.h"
