#include "proto/plan_internal.h"

#include <math.h>
#include <stdio.h>

#include "proto/limits.h"

int plan_field_refuse(const struct plan_field *at, int code, const char *field, const char *why,
                      double value)
{
    char pointer[LIMIT_POINTER_BYTES];
    snprintf(pointer, sizeof pointer, "%s%s%s", at->prefix, at->prefix[0] ? "." : "", field);
    return fault_set(at->fault, code, pointer, "%.9g %s", value, why);
}

int plan_field_number(const struct plan_field *at, const char *field, float v, float min, float max)
{
    if (!isfinite(v))
        return plan_field_refuse(at, ERR_NOT_FINITE, field, "is not finite", (double)v);
    if (v < min) return plan_field_refuse(at, ERR_RANGE, field, "is too small", (double)v);
    if (v > max) return plan_field_refuse(at, ERR_RANGE, field, "is too large", (double)v);
    return 0;
}

int plan_field_vector(const struct plan_field *at, const char *field, const float v[3], float min,
                      float max)
{
    for (int i = 0; i < 3; i++) {
        const int error = plan_field_number(at, field, v[i], min, max);
        if (error) return error;
    }
    return 0;
}

int plan_field_count(const struct plan_field *at, const char *field, int64_t v, int64_t min,
                     int64_t max)
{
    if (v < min) return plan_field_refuse(at, ERR_RANGE, field, "is too small", (double)v);
    if (v > max) return plan_field_refuse(at, ERR_LIMIT, field, "is above the limit", (double)v);
    return 0;
}

/* Scales are powers of two so that applying and undoing them is exact. */
int plan_field_scale(const struct plan_field *at, const char *field, float v, float min, float max)
{
    int exponent;
    const int error = plan_field_number(at, field, v, min, max);
    if (error) return error;
    if (frexpf(v, &exponent) != 0.5f)
        return plan_field_refuse(at, ERR_RANGE, field, "is no power of two", (double)v);
    return 0;
}

int plan_field_word(const struct plan_field *at, const char *field, uint32_t v, uint32_t first,
                    uint32_t last)
{
    if (v < first || v > last)
        return plan_field_refuse(at, ERR_RANGE, field, "is no known value", (double)v);
    return 0;
}

int plan_field_bits(const struct plan_field *at, const char *field, uint64_t v, uint64_t none,
                    uint64_t known)
{
    if (v & (~known | none))
        return plan_field_refuse(at, ERR_RANGE, field, "is a set with unknown bits", (double)v);
    return 0;
}
