#define GLOSSY_KERNELS glossy_kernels_avx512
#include "server/reconstruct/glossy/glossy_kernels_body.h"
