#include "proto/scene/scene_internal.h"

#include <math.h>
#include <stdio.h>

int record_refuse(const struct scene_record *at, const char *field, int code, double value,
                  const char *why)
{
    char pointer[LIMIT_POINTER_BYTES];
    snprintf(pointer, sizeof pointer, "%s[%llu]%s%s", scene_section_name(at->section),
             (unsigned long long)at->index, field[0] ? "." : "", field);
    return fault_set(at->fault, code, pointer, "%.9g %s", value, why);
}

int record_number(const struct scene_record *at, const char *field, float v, float min, float max)
{
    if (!isfinite(v)) return record_refuse(at, field, ERR_NOT_FINITE, (double)v, "is not finite");
    if (v < min) return record_refuse(at, field, ERR_RANGE, (double)v, "is too small");
    if (v > max) return record_refuse(at, field, ERR_RANGE, (double)v, "is too large");
    return 0;
}

int record_numbers(const struct scene_record *at, const char *field, const float *v, size_t count,
                   float min, float max)
{
    int error = 0;
    for (size_t i = 0; i < count && !error; i++) error = record_number(at, field, v[i], min, max);
    return error;
}

int record_index(const struct scene_record *at, const char *field, uint32_t index, uint32_t section)
{
    if (index < at->scene->count[section]) return 0;
    return record_refuse(at, field, ERR_RANGE, index, "is an index past the end");
}

int record_optional(const struct scene_record *at, const char *field, uint32_t index,
                    uint32_t section)
{
    return index == SCENE_NONE ? 0 : record_index(at, field, index, section);
}

int record_range(const struct scene_record *at, const char *field, uint32_t first, uint64_t count,
                 uint32_t section)
{
    if (first + count <= at->scene->count[section]) return 0;
    return record_refuse(at, field, ERR_RANGE, first, "starts a range that passes the end");
}

int record_value(const struct scene_record *at, const char *field, uint32_t value, uint32_t max)
{
    return value <= max ? 0 : record_refuse(at, field, ERR_RANGE, value, "is no known value");
}

int record_flags(const struct scene_record *at, uint32_t flags, uint32_t known)
{
    return flags & ~known ? record_refuse(at, "flags", ERR_RANGE, flags, "has unknown bits") : 0;
}

int record_reserved(const struct scene_record *at, uint32_t reserved)
{
    return reserved ? record_refuse(at, "reserved", ERR_RANGE, reserved, "is not 0") : 0;
}

int record_name(const struct scene_record *at, uint32_t name)
{
    return record_index(at, "name", name, SCENE_NAMES);
}
