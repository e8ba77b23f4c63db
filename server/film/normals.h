#pragma once
/* Unpacks rows of normals (proto/octahedron.h), several at a time. */
#include <stddef.h>
#include <stdint.h>

/* Unpacks `count` normals into x, y and z, from element `to` of each on. */
void normals_unpack16(const uint32_t *packed, size_t count, size_t to, float *const out[3]);
void normals_unpack8(const uint16_t *packed, size_t count, size_t to, float *const out[3]);
