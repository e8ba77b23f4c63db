#pragma once
/* The inner loops over sixteen sub-samples. */
#include "proto/runtime/kernels.h"
#include "worker/trace/field/lone_finder.h"

struct field_kernels {
    /* octahedron_unpack16 of each lane; and p->alike, p->open and p->settled of lone_finder.h,
     * which returns whether any lane is open. */
    void (*unpack_normals)(const uint32_t *packed, struct lanes3 *out);
    bool (*match_subs)(const struct surface_view *view, const struct lanes_mask *kept,
                       struct lone_pixels *p);
};

/* One for each instruction set (kernels.h). All compute the same bits. */
extern const struct field_kernels field_kernels_sse42, field_kernels_avx2, field_kernels_avx512;
