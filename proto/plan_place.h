#pragma once
/* Fields of a plan as its checks see them: where they stand, what may be in them. */
#include <stdint.h>

#include "proto/error.h"

/* Where a check stands: a prefix ("lights[2]") that each field's name is put behind. */
struct plan_place {
    const char *prefix;
    struct fault *fault;
};

/* Sets the fault: "<value> <why>" at the field. Returns code. */
int plan_place_refuse(const struct plan_place *at, int code, const char *field, const char *why,
                      double value);

/* 0, or ERR_NOT_FINITE, ERR_RANGE for what is not between min and max. */
int plan_place_number(const struct plan_place *at, const char *field, float v, float min,
                      float max);
int plan_place_vector(const struct plan_place *at, const char *field, const float v[3], float min,
                      float max);

/* 0, or ERR_RANGE below min, ERR_LIMIT above max. */
int plan_place_count(const struct plan_place *at, const char *field, int64_t v, int64_t min,
                     int64_t max);
