#include "proto/plan_place.h"

#include <math.h>
#include <stdio.h>

#include "proto/limits.h"

int plan_place_refuse(const struct plan_place *at, int code, const char *field, const char *why,
                      double value)
{
    char pointer[LIMIT_POINTER_BYTES];
    snprintf(pointer, sizeof pointer, "%s%s%s", at->prefix, at->prefix[0] ? "." : "", field);
    return fault_set(at->fault, code, pointer, "%.9g %s", value, why);
}

int plan_place_number(const struct plan_place *at, const char *field, float v, float min, float max)
{
    if (!isfinite(v))
        return plan_place_refuse(at, ERR_NOT_FINITE, field, "is not finite", (double)v);
    if (v < min) return plan_place_refuse(at, ERR_RANGE, field, "is too small", (double)v);
    if (v > max) return plan_place_refuse(at, ERR_RANGE, field, "is too large", (double)v);
    return 0;
}

int plan_place_vector(const struct plan_place *at, const char *field, const float v[3], float min,
                      float max)
{
    for (int i = 0; i < 3; i++) {
        const int error = plan_place_number(at, field, v[i], min, max);
        if (error) return error;
    }
    return 0;
}

int plan_place_count(const struct plan_place *at, const char *field, int64_t v, int64_t min,
                     int64_t max)
{
    if (v < min) return plan_place_refuse(at, ERR_RANGE, field, "is too small", (double)v);
    if (v > max) return plan_place_refuse(at, ERR_LIMIT, field, "is above the limit", (double)v);
    return 0;
}
