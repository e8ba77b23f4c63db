/* SSE4.2: runs anywhere. */
#define GLOSSY_KERNELS glossy_kernels_c
#include "server/reconstruct/glossy/glossy_kernels_body.h"
