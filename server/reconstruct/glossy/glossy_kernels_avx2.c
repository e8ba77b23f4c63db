#define GLOSSY_KERNELS glossy_kernels_avx2
#include "server/reconstruct/glossy/glossy_kernels_body.h"
