#pragma once
/* The inner loops over sixteen sub-samples. */
#include "proto/runtime/kernels.h"
#include "worker/trace/field/lone_finder.h"
#include "worker/trace/field/mixed.h"

struct field_kernels {
    /* Do octahedron_unpack16 for each lane, and set p->alike, p->open and p->settled of
     * lone_finder.h; the second returns whether any lane is open. */
    void (*unpack_normals)(const uint32_t *packed, struct lanes3 *out);
    bool (*match_subs)(const struct surface_view *view, const struct lanes_mask *kept,
                       struct lone_pixels *p);

    /* Fills the cells, from `first` on, of `count` pixels from image pixel (x, y) on, by their
     * planes. */
    void (*place_cells)(const struct surface_view *view, int32_t x, int32_t y, size_t count,
                        const float *depth, const uint32_t *normal, const uint32_t *id,
                        const struct mixed_cells *cells, size_t first);

    /* Sets *apart of those of `count` cells, from the first on, that show another surface than the
     * cell `offset` further on. */
    void (*compare_cells)(const struct surface_view *view, const struct mixed_cells *cells,
                          size_t first, size_t offset, size_t count, uint8_t *apart);

    /* Sets *mixed where two channels differ, 1 / 65535 each. */
    void (*mark_colours)(const uint16_t *a, const uint16_t *b, size_t count, uint8_t *mixed);

    /* Splits samples among the pixels in `lenders`, as sub-samples are lit (server's resolve.h):
     * only slots in out->lenders are set. s->point and s->normal are results, too. */
    void (*split_subs)(const struct surface_view *view,
                       const struct shown_surface pixels[MIXED_SLOTS], uint32_t lenders,
                       struct mixed_subs *s, struct mixed_shares *out);
};

/* One for each instruction set (kernels.h). All compute the same bits. */
extern const struct field_kernels field_kernels_sse42, field_kernels_avx2, field_kernels_avx512;
