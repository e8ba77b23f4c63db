/* The reference: what every other set of kernels is compared with. */
#define V_PLANE_KERNELS v_plane_kernels_c
#include "server/reconstruct/v_plane_kernels_body.h"
