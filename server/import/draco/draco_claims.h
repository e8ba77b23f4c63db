#pragma once
/* What the head of a Draco stream claims of its size, before a decoder believes it. */
#include <stddef.h>
#include <stdint.h>

/* Returns whether the stream is a mesh of bitstream 2.2, as glTF has it, whose counts of vertices
 * and triangles its bytes can hold: libdraco fills memory with what a few bytes claim. */
bool draco_claims_fit(const uint8_t *data, size_t size_bytes);
