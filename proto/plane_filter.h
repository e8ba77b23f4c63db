#pragma once
/* Makes a component of a tile's samples compress well: each number is replaced by its difference
 * from a prediction by its neighbours, which is small where surfaces are smooth. The numbers are
 * integers of the component's size, modulo 2^bits, so that any bits come back as they were.
 *
 * Differences are folded, so that small ones of either sign become small numbers: 0, -1, 1, -2
 * become 0, 1, 2, 3. */
#include <stddef.h>
#include <stdint.h>

enum plane_filter {
    PLANE_FILTER_NONE,
    PLANE_FILTER_LEFT,     /* less the number before, row by row; the first: less 0 */
    PLANE_FILTER_GRADIENT, /* less left + above - above left; what lies outside is 0 */
    PLANE_FILTER_XOR,      /* the bits that differ from the number before; the first: from 0 */
    PLANE_FILTER_COUNT
};

/* Returns the filter that leaves the fewest bits of width_px * height_px numbers of element_bytes
 * (1, 2, 4), judged by some of their rows. It depends on the numbers alone. */
enum plane_filter plane_filter_choose(const void *numbers, uint32_t element_bytes, int32_t width_px,
                                      int32_t height_px);

/* Writes the filtered numbers into out, which overlaps nothing. */
void plane_filter_apply(enum plane_filter filter, const void *numbers, uint32_t element_bytes,
                        int32_t width_px, int32_t height_px, void *out);

/* Restores the numbers in place. */
void plane_filter_undo(enum plane_filter filter, void *numbers, uint32_t element_bytes,
                       int32_t width_px, int32_t height_px);
