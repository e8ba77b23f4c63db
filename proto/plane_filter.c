#include "proto/plane_filter.h"

#include <assert.h>
#include <string.h>

#include "proto/limits.h"

#define ROWS_APART 8  /* that are looked at to choose by */
#define WORTH_PART 32 /* of the bits: what a filter must save to be worth its while */

/* They are parts of planes of other types. */
typedef uint16_t __attribute__((may_alias)) plane_16;
typedef uint32_t __attribute__((may_alias)) plane_32;

#define NUMBER      uint8_t
#define NAMED(name) name##_8
#include "proto/plane_filter_body.h"

#define NUMBER      plane_16
#define NAMED(name) name##_16
#include "proto/plane_filter_body.h"

#define NUMBER      plane_32
#define NAMED(name) name##_32
#include "proto/plane_filter_body.h"

enum plane_filter plane_filter_choose(const void *numbers, uint32_t element_bytes, int32_t width_px,
                                      int32_t height_px)
{
    const size_t width = (size_t)width_px, height = (size_t)height_px;
    assert(width_px > 0 && width_px <= LIMIT_TILE_SIDE_PX && height_px > 0);
    if (element_bytes == 1) return choose_8(numbers, width, height);
    if (element_bytes == 2) return choose_16(numbers, width, height);
    assert(element_bytes == 4);
    return choose_32(numbers, width, height);
}

void plane_filter_apply(enum plane_filter filter, const void *numbers, uint32_t element_bytes,
                        int32_t width_px, int32_t height_px, void *out)
{
    const size_t width = (size_t)width_px, height = (size_t)height_px;
    assert(filter < PLANE_FILTER_COUNT && width_px > 0 && height_px > 0);
    if (element_bytes == 1)
        apply_8(filter, numbers, width, height, out);
    else if (element_bytes == 2)
        apply_16(filter, numbers, width, height, out);
    else
        apply_32(filter, numbers, width, height, out);
}

void plane_filter_undo(enum plane_filter filter, void *numbers, uint32_t element_bytes,
                       int32_t width_px, int32_t height_px)
{
    const size_t width = (size_t)width_px, height = (size_t)height_px;
    assert(filter < PLANE_FILTER_COUNT && width_px > 0 && height_px > 0);
    if (element_bytes == 1)
        undo_8(filter, numbers, width, height);
    else if (element_bytes == 2)
        undo_16(filter, numbers, width, height);
    else
        undo_32(filter, numbers, width, height);
}
