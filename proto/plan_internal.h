#pragma once
/* What the checks of a plan share: where a field stands, and what may be in it. */
#include <stdint.h>

#include "proto/plan.h"

/* Where a check stands: a prefix ("lights[2]") that each field's name is put behind. */
struct plan_field {
    const char *prefix;
    struct fault *fault;
};

/* Sets the fault: "<value> <why>" at the field. Returns code. */
int plan_field_refuse(const struct plan_field *at, int code, const char *field, const char *why,
                      double value);

/* Check that a field is between `min` and `max`. They return 0, or ERR_NOT_FINITE, ERR_RANGE;
 * counts above `max` give ERR_LIMIT. A unit vector has length 1, too, a scale is a power of two. */
int plan_field_number(const struct plan_field *at, const char *field, float v, float min,
                      float max);
int plan_field_vector(const struct plan_field *at, const char *field, const float v[3], float min,
                      float max);
int plan_field_unit(const struct plan_field *at, const char *field, const float v[3], float min,
                    float max);
int plan_field_scale(const struct plan_field *at, const char *field, float v, float min, float max);
int plan_field_count(const struct plan_field *at, const char *field, int64_t v, int64_t min,
                     int64_t max);

/* Check that a field is a value of an enum that ends with `last`, or a set of bits of `known`. */
int plan_field_word(const struct plan_field *at, const char *field, uint32_t v, uint32_t first,
                    uint32_t last);
int plan_field_bits(const struct plan_field *at, const char *field, uint64_t v, uint64_t none,
                    uint64_t known);

/* Checks, for plan_check, that filters are known and that the planes that they read are there. */
int plan_filters_check(const struct plan_field *at, const struct plan *plan);
