#pragma once
/* The kernels that others are compared with: compiled for SSE4.2, but with what is fused (fused.h)
 * rounded once, by the C library. Those of AVX2 and AVX-512 give the same bits; the product's own
 * for SSE4.2 round twice. */
#include "server/reconstruct/glossy/glossy_kernels.h"
#include "server/reconstruct/indirect/indirect_kernels.h"
#include "server/reconstruct/indirect/v_plane_kernels.h"
#include "server/reconstruct/shadow/shadow_kernels.h"

/* By how much those may be off, of the greatest number of a field without extremes. */
#define REFERENCE_ROUNDING 1e-5f

extern const struct shadow_kernels shadow_kernels_reference;
extern const struct indirect_kernels indirect_kernels_reference;
extern const struct glossy_kernels glossy_kernels_reference;
extern const struct v_plane_kernels v_plane_kernels_reference;
