/* What v_plane_kernels are compared with. */
#include "tests/kernel/reference.h"

#define FUSED_BY_LIBRARY
#define V_PLANE_KERNELS v_plane_kernels_reference
#include "server/reconstruct/indirect/v_plane_kernels_body.h"
