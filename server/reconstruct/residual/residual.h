#pragma once
/* Filters what paths bring: light that no light field covers, of any lobe, material and light.
 *
 * The samples of a pixel are kept as two halves, each stratified in itself. Direct and indirect
 * light of the diffuse lobe before albedo, and the rest, go through three cascaded passes of
 * non-local means over 5 x 5, then over ever wider and sparser taps; in the first, each half is
 * weighed by what the other one shows (Rousselle, Knaus and Zwicker 2012, "Adaptive rendering with
 * non-local means filtering"). Weights look at patches of light, at their variance as the halves
 * tell it, and at depth, normal and albedo. As samples grow the variance falls, weights of pixels
 * that differ vanish, and the picture becomes the plain mean. docs/reconstruction.md, Residual
 * filter, has the formulas. */
#include "proto/plan.h"
#include "server/reconstruct/patch/patch.h"

struct residual_statistics {
    uint64_t pixels;        /* filtered */
    uint64_t tiles_skipped; /* times components: no light in reach */
};

/* Returns how many pixels around a block the filter reads; 0 where the plan has none. */
int32_t residual_halo_px(const struct plan *plan);

/* Means of a block's pixels, row by row. */
struct residual_picture {
    struct rect block;
    float *radiance[3];
    float *diffuse_direct[3], *diffuse_indirect[3];
    struct scratch *scratch; /* the patch's, borrowed */
    void *memory;            /* owned; taken from there */
};

/* Variances of the plain means of some of the block's pixels, row by row. */
struct residual_variance {
    struct rect rect;
    float *const *of; /* R, G, B */
};

/* Filters the block's pixels, with a patch that has the halo or ends with the image. Pixels do not
 * depend on where the block ends. `variance` becomes that of `radiance`; NULL: not wanted, which
 * changes nothing else. ERR_MEMORY. */
int residual_filter(const struct patch *patch, struct rect block,
                    const struct residual_variance *variance, struct residual_picture *out,
                    struct residual_statistics *statistics);
void residual_picture_fini(struct residual_picture *picture);

static inline size_t residual_picture_at(const struct residual_picture *p, int32_t x, int32_t y)
{
    return (size_t)(y - p->block.y0) * (size_t)rect_width(p->block) + (size_t)(x - p->block.x0);
}
