#pragma once
/* The passes of the filters of indirect light over one block: along x, then along y, each with the
 * receiver's width. */
#include "server/reconstruct/indirect/indirect_width.h"

struct indirect_pass {
    const struct indirect_kernels *kernels;
    bool lines;     /* rule B instead of rule A */
    int32_t reach;  /* pixels that the widest filter reads to both sides */
    uint32_t count; /* channels, INDIRECT_CHANNELS_MAX at most */
};

/* Returns the rows that the pass along x must have covered before the pass along y covers
 * `rect`. */
struct rect indirect_pass_tall(const struct indirect_neighbourhood *around, struct rect rect,
                               int32_t reach);

/* Filters arrays of the neighbourhood over `rect`. The field's widths must be set in
 * indirect_pass_tall. Overwrites `between`; `out` may be `in`. */
void indirect_pass_run(const struct indirect_pass *pass,
                       const struct indirect_neighbourhood *around, struct rect rect,
                       const float *const *in, float *const *between, float *const *out);
