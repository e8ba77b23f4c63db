#define V_PLANE_KERNELS v_plane_kernels_avx2
#include "server/reconstruct/indirect/v_plane_kernels_body.h"
