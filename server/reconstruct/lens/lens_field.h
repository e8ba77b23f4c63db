#pragma once
/* What the sheared filter of lens samples works with: where samples lie, and of each pixel that is
 * filtered what the layers so far have brought. */
#include "server/reconstruct/lens/lens_layer.h"
#include "server/reconstruct/lens/lens_shape.h"
#include "server/reconstruct/lens/lens_span.h"
#include "server/reconstruct/patch/patch.h"

#define LENS_SEGMENT 32 /* pixels of a row that are looked through together */

struct lens_field {
    const struct plan *plan;
    const struct patch *patch;
    const struct lens_kernels *kernels;
    struct lens_pattern pattern;
    struct lens_shape shape;
    uint32_t l;
    struct rect wide; /* filtered */
    struct rect seen; /* whose samples are read, which slopes tell */

    /* Of `seen`: jitter along lines; of each of l lines its height, left end and length. */
    float *along, *height, *left, *chord;
    struct lens_span *spans; /* of each sample: where all pixels' lie on the lens */
    struct rect known;       /* whose layers are known: `seen` and more */
    uint32_t *present;       /* bits of layers; of each row, sample and segment of `known` */
    uint32_t *any;           /* of each row and segment: those of all samples */
    uint32_t segments;       /* of a row: LENS_SEGMENT pixels each */
    uint32_t all;            /* bits of the layers of `seen` */
    /* Of the layer at hand: sums of pixels' slopes in it, how many; by which slope others pass. Of
     * a row, or of `seen`. */
    float *slopes, *count, *pass;
    uint32_t *row; /* numbers of a row of `seen` */

    /* Of `wide`: what the layers so far have brought (enum lens_view). */
    union {
        float *view[LENS_VIEWS];
        struct {
            float *through[LENS_GROUPS], *light[LENS_LIGHTS], *share, *spread;
        };
    };
    void *memory;
};

/* Where arrays of `seen` and `wide` have an image pixel. */
static inline size_t lens_seen(const struct lens_field *f, int32_t x, int32_t y)
{
    return (size_t)(y - f->seen.y0) * (size_t)rect_width(f->seen) + (size_t)(x - f->seen.x0);
}
static inline size_t lens_wide(const struct lens_field *f, int32_t x, int32_t y)
{
    return (size_t)(y - f->wide.y0) * (size_t)rect_width(f->wide) + (size_t)(x - f->wide.x0);
}

/* The segment that column x lies in, and the first column of one. */
static inline uint32_t lens_segment(const struct lens_field *f, int32_t x)
{
    return (uint32_t)(x - f->known.x0) / LENS_SEGMENT;
}
static inline int32_t lens_segment_x(const struct lens_field *f, uint32_t segment)
{
    return f->known.x0 + (int32_t)segment * LENS_SEGMENT;
}

/* Layers that sample j has in the segments of row y, and those of all samples. */
static inline const uint32_t *lens_present(const struct lens_field *f, uint32_t sample, int32_t y)
{
    const uint32_t row = (uint32_t)(y - f->known.y0);
    return f->present + (size_t)(row * f->l * f->l + sample) * f->segments;
}
static inline const uint32_t *lens_any(const struct lens_field *f, int32_t y)
{
    return f->any + (size_t)(y - f->known.y0) * f->segments;
}

/* Samples of a row of the patch from column x on. */
static inline const float *lens_slopes(const struct lens_field *f, uint32_t sample, int32_t x,
                                       int32_t y)
{
    const size_t area = (size_t)rect_area(f->patch->rect);
    return f->patch->lens_slope + sample * area + patch_pixel(f->patch, x, y);
}
static inline const float *lens_light(const struct lens_field *f, uint32_t sample, uint32_t channel,
                                      int32_t x, int32_t y)
{
    const size_t area = (size_t)rect_area(f->patch->rect);
    return f->patch->lens_radiance + (sample * 3 + channel) * area + patch_pixel(f->patch, x, y);
}

/* ERR_MEMORY; then fini still has to be called. `seen`: at most. */
int lens_field_create(const struct plan *plan, const struct patch *patch, struct rect wide,
                      struct rect seen, struct lens_field *out);
void lens_field_fini(struct lens_field *f);

/* log2 of the pixels of a cell's side in a layer of slopes up to `most`: where samples are few, a
 * fourth to an eighth of those, and half a pixel at least. */
int32_t lens_cell_level(float most, uint32_t l);

/* The slopes of a layer: from `low`, below `high`. */
void lens_layer_slopes(uint32_t layer, float *low, float *high);
