#pragma once
/* IEEE binary16, rounded to nearest even; the same bits with and without the CPU's F16C. */
#include <stddef.h>
#include <stdint.h>

#define HALF_MAX 65504.0f

/* Convert one number. Finite values beyond the range are clamped to +-HALF_MAX, so that a finite
 * sample never becomes infinite; NaN stays NaN. */
uint16_t half_from_float(float v);
float half_to_float(uint16_t h);

/* Convert rows. They use F16C where the CPU has it; the bits equal those of the scalar
 * functions. */
void half_from_floats(const float *in, uint16_t *out, size_t count);
void half_to_floats(const uint16_t *in, float *out, size_t count);
