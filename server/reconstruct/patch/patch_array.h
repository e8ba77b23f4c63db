#pragma once
/* Where a patch has the components of planes: the arrays of proto/plane.def.
 *
 * A plane's arrays share its components in their order. An ARRAY field has a pointer for each
 * component, three for a normal; a STACK has one, to all components, one after the other. */
#include <assert.h>
#include <stddef.h>

#include "server/reconstruct/patch/patch.h"

/* How an element becomes a number of the patch. radiance_scale and length_unit are taken out. */
enum patch_unpack {
    PATCH_AS_IT_IS,
    PATCH_DISTANCE,            /* f32, cut at SURFACE_DISTANCE_MAX */
    PATCH_SUB_DISTANCE,        /* f16 of a sub-sample: its distance from the pixel's */
    PATCH_NORMAL,              /* u32 to x, y and z; 0 without a surface */
    PATCH_SUB_NORMAL,          /* u16 to the same */
    PATCH_SUB_ID,              /* u16 to u32 */
    PATCH_UNORM,               /* u16 to 0 ... 1 */
    PATCH_NUMBER,              /* f16 */
    PATCH_RADIANCE,            /* f16 */
    PATCH_LENGTH,              /* f16 */
    PATCH_NEARNESS,            /* f16 */
    PATCH_RADIANCE_AND_LENGTH, /* f16: of four components the last a length */
};

/* Which filters read an array outside the core. It is gathered there where the plan has them. */
enum patch_reach {
    PATCH_CORE = 0, /* none */
    PATCH_FAR = 1,  /* all */
    PATCH_FAR_INDIRECT = 2,
    PATCH_FAR_LOBES = 4,
    PATCH_FAR_PATHS = 8,     /* what tells of errors of paths */
    PATCH_FAR_RESIDUAL = 16, /* the filter of what paths bring */
    PATCH_FAR_HISTORY = 32,  /* what finds a point in other frames */
    PATCH_FAR_IDS = PATCH_FAR_INDIRECT | PATCH_FAR_LOBES | PATCH_FAR_HISTORY,
};

struct patch_array {
    size_t offset;     /* of its first pointer in struct patch; pointers follow each other */
    uint32_t pointers; /* 0: the plane has no further arrays */
    bool stacked;
    uint32_t element_bytes;
    enum patch_unpack unpack;
    enum patch_reach reach;
};

/* Returns a plane's arrays; for a light's plane those of the first light. */
const struct patch_array *patch_arrays(uint32_t slot);

/* Returns pointer i of an array of the plane, in this patch. */
void *patch_array_get(const struct patch *patch, uint32_t slot, const struct patch_array *array,
                      uint32_t i);
void patch_array_set(struct patch *patch, uint32_t slot, const struct patch_array *array,
                     uint32_t i, void *to);

/* Returns how many pointers a component has. */
static inline uint32_t patch_array_each(const struct patch_array *array)
{
    return array->unpack == PATCH_NORMAL || array->unpack == PATCH_SUB_NORMAL ? 3 : 1;
}

/* Returns how many components the array has, if the plane has `components` from its first on. */
static inline uint32_t patch_array_holds(const struct patch_array *array, uint32_t components)
{
    assert(array->pointers > 0);
    const uint32_t room = array->pointers / patch_array_each(array);
    return array->stacked || components < room ? components : room;
}
