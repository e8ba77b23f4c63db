#include "server/import/gltf/gltf_json.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "proto/json.h"
#include "proto/scene/scene.h"

void gltf_place_set(gltf_place out, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(out, LIMIT_POINTER_BYTES, format, args);
    va_end(args);
}

/* "place.key", or "key" at the root. */
static void member_place(gltf_place out, const char *place, const char *key)
{
    gltf_place_set(out, "%s%s%s", place, place[0] == 0 ? "" : ".", key);
}

static int wrong_type(const json_t *value, const char *place, const char *key, const char *wanted,
                      struct fault *fault)
{
    gltf_place at;
    member_place(at, place, key);
    return fault_set(fault, ERR_TYPE, at, "it is %s, not %s", json_type_name(value), wanted);
}

int gltf_object(const json_t *of, const char *place, const char *key, const json_t **out,
                struct fault *fault)
{
    *out = json_object_get(of, key);
    if (*out == NULL || json_is_object(*out)) return 0;
    return wrong_type(*out, place, key, "an object", fault);
}

int gltf_array(const json_t *of, const char *place, const char *key, const json_t **out,
               struct fault *fault)
{
    *out = json_object_get(of, key);
    if (*out == NULL || json_is_array(*out)) return 0;
    return wrong_type(*out, place, key, "an array", fault);
}

int gltf_text(const json_t *of, const char *place, const char *key, const char **out,
              struct fault *fault)
{
    const json_t *value = json_object_get(of, key);
    *out = json_string_value(value);
    if (value == NULL || *out != NULL) return 0;
    return wrong_type(value, place, key, "a string", fault);
}

size_t gltf_count(const json_t *root, const char *array)
{
    return json_array_size(json_object_get(root, array));
}

int gltf_item(const json_t *root, const char *array, size_t i, const json_t **out, gltf_place place,
              struct fault *fault)
{
    gltf_place_set(place, "%s[%zu]", array, i);
    *out = json_array_get(json_object_get(root, array), i);
    if (json_is_object(*out)) return 0;
    if (*out == NULL) return fault_set(fault, ERR_NOT_FOUND, place, "it does not exist");
    return fault_set(fault, ERR_TYPE, place, "it is %s, not an object", json_type_name(*out));
}

int gltf_flag(const json_t *of, const char *place, const char *key, bool *inout,
              struct fault *fault)
{
    const json_t *value = json_object_get(of, key);
    if (value == NULL) return 0;
    if (!json_is_boolean(value)) return wrong_type(value, place, key, "a boolean", fault);
    *inout = json_is_true(value);
    return 0;
}

/* Limits are floats, and so is what becomes of the value: 1e12 is not above the limit 1e12f. */
static int check_range(double value, double lowest, double highest, const char *place,
                       const char *key, struct fault *fault)
{
    if (value >= lowest && (value <= highest || (float)value <= (float)highest)) return 0;
    gltf_place at;
    member_place(at, place, key);
    if (value < lowest) return fault_set(fault, ERR_RANGE, at, "%g is below %g", value, lowest);
    return fault_set(fault, ERR_RANGE, at, "%g is above %g", value, highest);
}

int gltf_number(const json_t *of, const char *place, const char *key, double lowest, double highest,
                double *inout, struct fault *fault)
{
    const json_t *value = json_object_get(of, key);
    if (value == NULL) return 0;
    if (!json_is_number(value)) return wrong_type(value, place, key, "a number", fault);
    int rc = check_range(json_number_value(value), lowest, highest, place, key, fault);
    if (rc == 0) *inout = json_number_value(value);
    return rc;
}

int gltf_integer(const json_t *of, const char *place, const char *key, uint64_t highest,
                 uint64_t *inout, struct fault *fault)
{
    const json_t *value = json_object_get(of, key);
    if (value == NULL) return 0;
    double number = json_number_value(value);
    if (!json_is_number(value) || number != floor(number))
        return wrong_type(value, place, key, "an integer", fault);
    int rc = check_range(number, 0, (double)highest, place, key, fault);
    if (rc != 0) return rc;
    /* An integer written as 3.0 is one. Reals up to 2^53 convert exactly. */
    if (json_is_integer(value))
        *inout = (uint64_t)json_integer_value(value);
    else if (number < 0x1p53)
        *inout = (uint64_t)number;
    else
        return wrong_type(value, place, key, "an integer", fault);
    return 0;
}

int gltf_index(const json_t *of, const char *place, const char *key, size_t count, uint32_t *out,
               struct fault *fault)
{
    uint64_t index = SCENE_NONE;
    int rc = gltf_integer(of, place, key, SCENE_NONE - 1, &index, fault);
    if (rc != 0) return rc;
    *out = (uint32_t)index;
    if (index == SCENE_NONE || index < count) return 0;
    gltf_place at;
    member_place(at, place, key);
    return fault_set(fault, ERR_RANGE, at, "%" PRIu64 " names nothing: there are %zu", index,
                     count);
}

int gltf_vector(const json_t *of, const char *place, const char *key, size_t n, double lowest,
                double highest, double *inout, bool *present, struct fault *fault)
{
    const json_t *value = json_object_get(of, key);
    if (present != NULL) *present = value != NULL;
    if (value == NULL) return 0;
    if (!json_is_array(value)) return wrong_type(value, place, key, "an array", fault);
    gltf_place at;
    member_place(at, place, key);
    if (json_array_size(value) != n)
        return fault_set(fault, ERR_RANGE, at, "it has %zu elements, not %zu",
                         json_array_size(value), n);
    for (size_t i = 0; i < n; i++) {
        const json_t *element = json_array_get(value, i);
        if (!json_is_number(element))
            return fault_set(fault, ERR_TYPE, at, "element %zu is %s, not a number", i,
                             json_type_name(element));
        double number = json_number_value(element);
        if (!(number >= lowest && number <= highest))
            return fault_set(fault, ERR_RANGE, at, "element %zu, %g, is not in [%g, %g]", i, number,
                             lowest, highest);
        inout[i] = number;
    }
    return 0;
}

int gltf_float(const json_t *of, const char *place, const char *key, double lowest, double highest,
               float *inout, struct fault *fault)
{
    double value = (double)*inout;
    int rc = gltf_number(of, place, key, lowest, highest, &value, fault);
    *inout = (float)value;
    return rc;
}

int gltf_floats(const json_t *of, const char *place, const char *key, size_t n, double lowest,
                double highest, float *inout, struct fault *fault)
{
    double values[4] = {0, 0, 0, 0};
    bool present;
    if (n > 4) return fault_set(fault, ERR_LIMIT, place, "%zu numbers", n);
    int rc = gltf_vector(of, place, key, n, lowest, highest, values, &present, fault);
    for (size_t i = 0; rc == 0 && present && i < n; i++) inout[i] = (float)values[i];
    return rc;
}

int gltf_extension(const json_t *of, const char *place, const char *name, const json_t **out,
                   gltf_place out_place, struct fault *fault)
{
    const json_t *extensions;
    *out = NULL;
    int rc = gltf_object(of, place, "extensions", &extensions, fault);
    if (rc != 0 || extensions == NULL) return rc;
    member_place(out_place, place, "extensions");
    gltf_place parent;
    gltf_place_set(parent, "%s", out_place);
    rc = gltf_object(extensions, parent, name, out, fault);
    member_place(out_place, parent, name);
    return rc;
}
