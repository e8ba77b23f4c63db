#define V_PLANE_KERNELS v_plane_kernels_avx512
#include "server/reconstruct/indirect/v_plane_kernels_body.h"
