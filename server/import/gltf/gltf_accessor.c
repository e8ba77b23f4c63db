#include "server/import/gltf/gltf_accessor.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* Elements of an accessor that is zero but for its sparse part: a few bytes that ask for many. */
#define ZERO_ELEMENTS 16777216u

enum component {
    COMPONENT_I8 = 5120,
    COMPONENT_U8 = 5121,
    COMPONENT_I16 = 5122,
    COMPONENT_U16 = 5123,
    COMPONENT_U32 = 5125,
    COMPONENT_F32 = 5126
};

/* `count` elements in memory; data is NULL where all of them are zero. */
struct elements {
    const uint8_t *data;
    size_t stride_bytes;
    uint32_t count;
    uint32_t components;
    uint32_t type; /* enum component */
    bool normalized;
};

struct accessor {
    const json_t *json;
    gltf_place place;
    struct elements base;
};

static size_t component_bytes(uint32_t type)
{
    switch (type) {
    case COMPONENT_I8:
    case COMPONENT_U8:
        return 1;
    case COMPONENT_I16:
    case COMPONENT_U16:
        return 2;
    case COMPONENT_U32:
    case COMPONENT_F32:
        return 4;
    default:
        return 0;
    }
}

static uint32_t components_of(const char *type)
{
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    for (uint32_t i = 0; i < 4; i++)
        if (strcmp(type, names[i]) == 0) return i + 1;
    return strcmp(type, "MAT4") == 0 ? 16 : 0; /* smaller matrices are used by nothing */
}

/* Points `e` into a buffer view at byteOffset of `json`, checking that all elements fit. */
static int bind_elements(struct gltf *g, const json_t *json, const char *place, uint32_t view_index,
                         struct elements *e, struct fault *fault)
{
    struct gltf_view view;
    uint64_t offset = 0;
    int rc = gltf_integer(json, place, "byteOffset", LIMIT_ASSET_BYTES, &offset, fault);
    if (rc == 0) rc = gltf_view_open(g, view_index, &view, fault);
    if (rc != 0) return rc;
    size_t element_bytes = component_bytes(e->type) * e->components;
    e->stride_bytes = view.stride_bytes != 0 ? view.stride_bytes : element_bytes;
    if (e->stride_bytes < element_bytes)
        return fault_set(fault, ERR_RANGE, place,
                         "a byteStride of %zu is too short for elements of %zu bytes",
                         e->stride_bytes, element_bytes);
    uint64_t needed =
        e->count == 0 ? 0 : (uint64_t)(e->count - 1) * e->stride_bytes + element_bytes;
    if (offset > view.size_bytes || needed > view.size_bytes - offset)
        return fault_set(fault, ERR_TRUNCATED, place,
                         "%" PRIu32 " elements need %" PRIu64 " bytes at %" PRIu64
                         " of a view of %zu",
                         e->count, needed, offset, view.size_bytes);
    e->data = view.data + offset;
    return 0;
}

static int read_component_type(const json_t *json, const char *place, uint32_t *out,
                               struct fault *fault)
{
    uint64_t type = 0;
    int rc = gltf_integer(json, place, "componentType", UINT32_MAX, &type, fault);
    if (rc != 0) return rc;
    *out = (uint32_t)type;
    if (component_bytes(*out) != 0) return 0;
    return fault_set(fault, ERR_RANGE, place, "componentType %" PRIu64 " does not exist", type);
}

static int read_count(const json_t *json, const char *place, uint32_t *out, struct fault *fault)
{
    uint64_t count = 0;
    int rc = gltf_integer(json, place, "count", 3ull * LIMIT_TRIANGLES, &count, fault);
    *out = (uint32_t)count;
    if (rc == 0 && count == 0)
        return fault_set(fault, ERR_RANGE, place, "an accessor has at least one element");
    return rc;
}

static int check_zeros(const struct accessor *a, struct fault *fault)
{
    if (a->base.count <= ZERO_ELEMENTS) return 0;
    return fault_set(fault, ERR_LIMIT, a->place,
                     "%" PRIu32 " elements without a bufferView are too many", a->base.count);
}

static int open_accessor(struct gltf *g, uint32_t index, struct accessor *out, struct fault *fault)
{
    *out = (struct accessor){0};
    uint32_t view = SCENE_NONE;
    const char *type = NULL;
    int rc = gltf_item(g->root, "accessors", index, &out->json, out->place, fault);
    if (rc == 0) rc = read_component_type(out->json, out->place, &out->base.type, fault);
    if (rc == 0) rc = read_count(out->json, out->place, &out->base.count, fault);
    if (rc == 0) rc = gltf_flag(out->json, out->place, "normalized", &out->base.normalized, fault);
    if (rc == 0) rc = gltf_text(out->json, out->place, "type", &type, fault);
    if (rc == 0)
        rc = gltf_index(out->json, out->place, "bufferView", gltf_count(g->root, "bufferViews"),
                        &view, fault);
    if (rc != 0) return rc;
    out->base.components = components_of(type != NULL ? type : "");
    if (out->base.components == 0)
        return fault_set(fault, ERR_TYPE, out->place, "the type \"%.40s\" is not usable here",
                         type != NULL ? type : "");
    if (view == SCENE_NONE) return check_zeros(out, fault);
    return bind_elements(g, out->json, out->place, view, &out->base, fault);
}

int gltf_accessor_components(struct gltf *g, uint32_t accessor, uint32_t *out, struct fault *fault)
{
    struct accessor a;
    int rc = open_accessor(g, accessor, &a, fault);
    *out = rc == 0 ? a.base.components : 0;
    return rc;
}

int gltf_accessor_scale(struct gltf *g, uint32_t accessor, float *out, struct fault *fault)
{
    struct accessor a;
    int rc = open_accessor(g, accessor, &a, fault);
    *out = 1;
    if (rc != 0 || !a.base.normalized || a.base.type == COMPONENT_F32) return rc;
    const bool is_signed = a.base.type == COMPONENT_I8 || a.base.type == COMPONENT_I16;
    const unsigned bits = 8 * (unsigned)component_bytes(a.base.type) - is_signed;
    *out = 1.0f / (float)((1ull << bits) - 1);
    return 0;
}

static uint32_t load_unsigned(const struct elements *e, size_t i, size_t c)
{
    const uint8_t *at = e->data + i * e->stride_bytes + c * component_bytes(e->type);
    uint16_t u16;
    uint32_t u32;
    switch (e->type) {
    case COMPONENT_U8:
        return *at;
    case COMPONENT_U16:
        memcpy(&u16, at, sizeof u16);
        return u16;
    default:
        memcpy(&u32, at, sizeof u32);
        return u32;
    }
}

static float load_float(const struct elements *e, size_t i, size_t c)
{
    const uint8_t *at = e->data + i * e->stride_bytes + c * component_bytes(e->type);
    float value;
    int16_t i16;
    switch (e->type) {
    case COMPONENT_F32:
        memcpy(&value, at, sizeof value);
        return value;
    case COMPONENT_I8:
        value = (float)(int8_t)*at;
        return !e->normalized ? value : value < -127 ? -1 : value / 127;
    case COMPONENT_I16:
        memcpy(&i16, at, sizeof i16);
        return !e->normalized ? i16 : i16 < -32767 ? -1 : (float)i16 / 32767;
    default:
        break;
    }
    value = (float)load_unsigned(e, i, c);
    if (!e->normalized) return value;
    return e->type == COMPONENT_U8 ? value / 255 : value / 65535;
}

/* The sparse part's two arrays; count 0 when there is none. */
struct sparse {
    struct elements indices, values;
    gltf_place place;
};

static int open_sparse_part(struct gltf *g, const json_t *of, const char *of_place, const char *key,
                            bool typed, struct elements *e, struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    uint32_t view = SCENE_NONE;
    gltf_place_set(place, "%s.%s", of_place, key);
    int rc = gltf_object(of, of_place, key, &json, fault);
    if (rc == 0 && json == NULL) return fault_set(fault, ERR_MISSING, place, "it is not there");
    if (rc == 0 && typed) rc = read_component_type(json, place, &e->type, fault);
    if (rc == 0)
        rc =
            gltf_index(json, place, "bufferView", gltf_count(g->root, "bufferViews"), &view, fault);
    if (rc == 0 && view == SCENE_NONE)
        return fault_set(fault, ERR_MISSING, place, "it has no bufferView");
    return rc != 0 ? rc : bind_elements(g, json, place, view, e, fault);
}

static int open_sparse(struct gltf *g, const struct accessor *a, struct sparse *out,
                       struct fault *fault)
{
    *out = (struct sparse){0};
    const json_t *json;
    int rc = gltf_object(a->json, a->place, "sparse", &json, fault);
    if (rc != 0 || json == NULL) return rc;
    gltf_place_set(out->place, "%s.sparse", a->place);
    uint32_t count;
    rc = read_count(json, out->place, &count, fault);
    if (rc != 0) return rc;
    out->indices = (struct elements){.count = count, .components = 1};
    out->values = a->base;
    out->values.count = count;
    rc = open_sparse_part(g, json, out->place, "indices", true, &out->indices, fault);
    if (rc == 0 && out->indices.type != COMPONENT_U8 && out->indices.type != COMPONENT_U16 &&
        out->indices.type != COMPONENT_U32)
        rc = fault_set(fault, ERR_TYPE, out->place, "its indices are not unsigned integers");
    if (rc == 0) rc = open_sparse_part(g, json, out->place, "values", false, &out->values, fault);
    return rc;
}

/* The element that sparse entry i replaces. */
static int sparse_target(const struct sparse *s, size_t i, uint32_t count, uint32_t *out,
                         struct fault *fault)
{
    *out = load_unsigned(&s->indices, i, 0);
    if (*out < count) return 0;
    gltf_place place;
    gltf_place_set(place, "%s.indices[%zu]", s->place, i);
    return fault_set(fault, ERR_RANGE, place, "%" PRIu32 " is not below the count %" PRIu32, *out,
                     count);
}

static int check_shape(const struct accessor *a, uint32_t components, struct fault *fault)
{
    if (a->base.components == components) return 0;
    return fault_set(fault, ERR_TYPE, a->place, "it has %u components where %u are needed",
                     a->base.components, components);
}

int gltf_read_floats(struct gltf *g, uint32_t accessor, uint32_t components, uint32_t *count,
                     float **out, struct fault *fault)
{
    struct accessor a;
    struct sparse sparse;
    *out = NULL;
    int rc = open_accessor(g, accessor, &a, fault);
    if (rc == 0) rc = check_shape(&a, components, fault);
    if (rc == 0 && a.base.count > LIMIT_VERTICES)
        rc =
            fault_set(fault, ERR_LIMIT, a.place, "%" PRIu32 " elements are too many", a.base.count);
    if (rc == 0 && a.base.type == COMPONENT_U32)
        rc = fault_set(fault, ERR_TYPE, a.place, "32-bit integers are for indices only");
    if (rc == 0) rc = open_sparse(g, &a, &sparse, fault);
    if (rc != 0) return rc;
    size_t total = (size_t)a.base.count * components;
    float *values = calloc(total + 1, sizeof *values);
    if (values == NULL)
        return fault_set(fault, ERR_MEMORY, a.place, "no memory for %zu numbers", total);
    for (size_t i = 0; a.base.data != NULL && i < a.base.count; i++)
        for (size_t c = 0; c < components; c++)
            values[i * components + c] = load_float(&a.base, i, c);
    for (size_t i = 0; rc == 0 && i < sparse.indices.count; i++) {
        uint32_t target;
        rc = sparse_target(&sparse, i, a.base.count, &target, fault);
        for (size_t c = 0; rc == 0 && c < components; c++)
            values[(size_t)target * components + c] = load_float(&sparse.values, i, c);
    }
    if (rc != 0) {
        free(values);
        return rc;
    }
    *count = a.base.count;
    *out = values;
    return 0;
}

int gltf_read_indices(struct gltf *g, uint32_t accessor, uint32_t *count, uint32_t **out,
                      struct fault *fault)
{
    struct accessor a;
    struct sparse sparse;
    *out = NULL;
    int rc = open_accessor(g, accessor, &a, fault);
    if (rc == 0) rc = check_shape(&a, 1, fault);
    if (rc == 0 && a.base.type != COMPONENT_U8 && a.base.type != COMPONENT_U16 &&
        a.base.type != COMPONENT_U32)
        rc = fault_set(fault, ERR_TYPE, a.place, "indices are unsigned integers");
    if (rc == 0) rc = open_sparse(g, &a, &sparse, fault);
    if (rc != 0) return rc;
    uint32_t *values = calloc(a.base.count, sizeof *values);
    if (values == NULL)
        return fault_set(fault, ERR_MEMORY, a.place, "no memory for %" PRIu32 " indices",
                         a.base.count);
    for (size_t i = 0; a.base.data != NULL && i < a.base.count; i++)
        values[i] = load_unsigned(&a.base, i, 0);
    for (size_t i = 0; rc == 0 && i < sparse.indices.count; i++) {
        uint32_t target;
        rc = sparse_target(&sparse, i, a.base.count, &target, fault);
        if (rc == 0) values[target] = load_unsigned(&sparse.values, i, 0);
    }
    if (rc != 0) {
        free(values);
        return rc;
    }
    *count = a.base.count;
    *out = values;
    return 0;
}
