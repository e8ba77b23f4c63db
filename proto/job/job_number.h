#pragma once
/* Floats as the shortest decimals that read back to the same bits. */
#include <jansson.h>

/* NULL on failed allocation. */
json_t *job_number_write(float v);
json_t *job_number_write3(const float v[3]);

/* v rounded to so many decimal digits. */
double job_number_rounded(double v, int digits);
