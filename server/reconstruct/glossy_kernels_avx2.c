#define GLOSSY_KERNELS glossy_kernels_avx2
#include "server/reconstruct/glossy_kernels_body.h"
