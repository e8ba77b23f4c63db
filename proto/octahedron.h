#pragma once
/* Unit vectors on the octahedron: two signed normalised integers a direction.
 * Source: Meyer et al. 2010, "On floating-point normal vectors". */
#include <stddef.h>
#include <stdint.h>

/* 2 x 16 bits, x in the low half; error below 5e-5 rad. `n` need not be unit, must not be zero. */
uint32_t octahedron_pack16(const float n[3]);
void octahedron_unpack16(uint32_t packed, float n[3]);

/* 2 x 8 bits; error below 0.013 rad. For matching surfaces, not for shading. */
uint16_t octahedron_pack8(const float n[3]);
void octahedron_unpack8(uint16_t packed, float n[3]);

/* The same of a row. */
void octahedron_unpack8_row(const uint16_t *packed, size_t count, float *x, float *y, float *z);
