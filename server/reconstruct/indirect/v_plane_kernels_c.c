/* SSE4.2: runs anywhere. */
#define V_PLANE_KERNELS v_plane_kernels_c
#include "server/reconstruct/indirect/v_plane_kernels_body.h"
