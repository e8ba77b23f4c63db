#pragma once
/* Rows of packed normals (proto/octahedron.h), read side by side. */
#include <stddef.h>
#include <stdint.h>

/* `count` of them into x, y and z, from element `to` on of each. */
void normals_unpack16(const uint32_t *packed, size_t count, size_t to, float *const out[3]);
void normals_unpack8(const uint16_t *packed, size_t count, size_t to, float *const out[3]);
