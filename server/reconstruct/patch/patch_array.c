#include "server/reconstruct/patch/patch_array.h"

#include <string.h>

/* IN: where a patch has the fields. */
#define ROW(type, field, stacked, unpack, reach)                                                   \
    {offsetof(struct patch, field),                                                                \
     sizeof(((struct patch *)0)->field) / sizeof(void *),                                          \
     stacked,                                                                                      \
     sizeof(type),                                                                                 \
     PATCH_##unpack,                                                                               \
     PATCH_##reach},
#define ARRAY(type, field, dimensions, unpack, reach) ROW(type, IN field, false, unpack, reach)
#define STACK(type, field, unpack, reach)             ROW(type, IN field, true, unpack, reach)

static const struct patch_array *const lists[PLANE_ID_COUNT + LIGHT_PLANE_COUNT] = {
#define IN
#define PLANE(number, name, key, type, components, per, values, merge, arrays, ...)                \
    [number] = (const struct patch_array[]){arrays{0}},
#include "proto/plane.def"
#undef IN
#define IN lights[0].
#define LIGHT_PLANE(number, name, key, type, components, per, values, arrays, ...)                 \
    [PLANE_ID_COUNT + number] = (const struct patch_array[]){arrays{0}},
#include "proto/plane.def"
};

const struct patch_array *patch_arrays(uint32_t slot)
{
    return lists[samples_row(slot)];
}

static size_t offset_of(uint32_t slot, const struct patch_array *array, uint32_t i)
{
    return array->offset + samples_slot_light(slot) * sizeof(struct patch_light) +
           i * sizeof(void *);
}

void *patch_array_get(const struct patch *patch, uint32_t slot, const struct patch_array *array,
                      uint32_t i)
{
    void *at;
    memcpy(&at, (const uint8_t *)patch + offset_of(slot, array, i), sizeof at);
    return at;
}

void patch_array_set(struct patch *patch, uint32_t slot, const struct patch_array *array,
                     uint32_t i, void *to)
{
    memcpy((uint8_t *)patch + offset_of(slot, array, i), &to, sizeof to);
}
